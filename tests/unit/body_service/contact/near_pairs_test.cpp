#include "contact/near_pairs.hpp"

#include <gtest/gtest.h>

#include "body_cases.hpp"

namespace copepod::body {
namespace {

constexpr double um = 1e-6;

/// A row of beads (radius 4 µm) along z whose surfaces are `gap` apart.
BodySetup row_of_beads(int beads, double gap_m) {
  BodySetup setup = setup_of({}, 1e-9);
  for (int i = 0; i < beads; ++i) setup.bodies.push_back(bead("b", {0, 0, i * (8 * um + gap_m)}));
  return setup;
}

TEST(NearPairs, AreNeighboursOnlyHoweverManyBodiesThereAre) {
  for (const int beads : {10, 1000}) {
    const BodyModel model(row_of_beads(beads, 0.1 * um));
    NearPairs near_pairs(model, {});
    const auto& pairs = near_pairs.at(model.initial_state().position_m);
    ASSERT_EQ(pairs.size(), static_cast<std::size_t>(beads - 1));
    for (int i = 0; i + 1 < beads; ++i) EXPECT_EQ(pairs[i], BodyPair(i, i + 1));
  }
}

TEST(NearPairs, LeaveOutBodiesThatCannotTouchBeforeThePairsAreListedAnew) {
  const BodyModel model(row_of_beads(5, 2.1 * um));  // the margins of two beads add up to 2 µm
  EXPECT_TRUE(NearPairs(model, {}).at(model.initial_state().position_m).empty());
}

TEST(NearPairs, HoldEveryPairThatCouldTouchWhileBodiesMove) {
  const BodyModel model(row_of_beads(2, 50 * um));
  NearPairs near_pairs(model, {});
  Eigen::Matrix3Xd position_m = model.initial_state().position_m;
  ASSERT_TRUE(near_pairs.at(position_m).empty());
  while (position_m(2, 1) > 8 * um) {
    position_m(2, 1) -= 0.3 * um;
    near_pairs.at(position_m);
  }
  EXPECT_EQ(near_pairs.at(position_m).size(), 1U);
}

TEST(NearPairs, ReachAcrossPeriodicFaces) {
  const BodyModel model(setup_of({bead("low", {0, 0, 2 * um}), bead("high", {0, 0, 97 * um})}, 1e-9));
  EXPECT_TRUE(NearPairs(model, {}).at(model.initial_state().position_m).empty());
  EXPECT_EQ(NearPairs(model, {0, 0, 100 * um}).at(model.initial_state().position_m).size(), 1U);
}

TEST(NearPairs, ListBodiesLongerThanThePeriodicBox) {
  const BodyModel model(setup_of({bead("ball", {0, 0, 0}), capsule("snake", {50 * um, 0, 0})}, 1e-9));
  EXPECT_TRUE(NearPairs(model, {0, 0, 17 * um}).longer_than_the_box().empty());
  EXPECT_EQ(NearPairs(model, {0, 0, 15 * um}).longer_than_the_box(), std::vector<int>{1});
}

}  // namespace
}  // namespace copepod::body
