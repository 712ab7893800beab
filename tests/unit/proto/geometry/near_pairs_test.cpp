#include "geometry/near_pairs.hpp"

#include <gtest/gtest.h>

namespace copepod {
namespace {

const Shape ball{ShapeKind::sphere, 4.0, 0.0};

/// Centres along z whose distance is `spacing`.
Eigen::Matrix3Xd row(int balls, double spacing) {
  Eigen::Matrix3Xd centres = Eigen::Matrix3Xd::Zero(3, balls);
  for (int i = 0; i < balls; ++i) centres(2, i) = i * spacing;
  return centres;
}

std::vector<Shape> balls(int number) { return std::vector<Shape>(static_cast<std::size_t>(number), ball); }

TEST(NearPairs, AreNeighboursOnlyHoweverManyBodiesThereAre) {
  for (const int number : {10, 1000}) {
    NearPairs near_pairs(balls(number), 0.0, {});
    const auto& pairs = near_pairs.at(row(number, 8.1));
    ASSERT_EQ(pairs.size(), static_cast<std::size_t>(number - 1));
    for (int i = 0; i + 1 < number; ++i) EXPECT_EQ(pairs[static_cast<std::size_t>(i)], BodyPair(i, i + 1));
  }
}

TEST(NearPairs, AscendWhereverTheBodiesAre) {
  // Balls and capsules scattered over a plane: the grid finds their pairs level by level and cell by cell.
  std::vector<Shape> shapes;
  Eigen::Matrix3Xd centres = Eigen::Matrix3Xd::Zero(3, 300);
  for (int i = 0; i < 300; ++i) {
    shapes.push_back(i % 5 == 0 ? Shape{ShapeKind::capsule, 4.0, 20.0} : ball);
    centres(0, i) = 37 * i % 101;
    centres(1, i) = 53 * i % 97;
  }
  std::vector<BodyPair> expected;
  for (int A = 0; A < 300; ++A) {
    for (int B = A + 1; B < 300; ++B) {
      const double reach = bounding_radius_m(shapes[A]) + bounding_radius_m(shapes[B]) + 2.0;  // with both margins
      if ((centres.col(A) - centres.col(B)).norm() < reach) expected.emplace_back(A, B);
    }
  }
  EXPECT_GT(expected.size(), 2000U);
  EXPECT_EQ(NearPairs(shapes, 0.0, {}).at(centres), expected);
}

TEST(NearPairs, LeaveOutBodiesThatCannotComeNearBeforeThePairsAreListedAnew) {
  const auto centres = row(5, 10.1);  // the margins of two balls add up to 2
  EXPECT_TRUE(NearPairs(balls(5), 0.0, {}).at(centres).empty());
  EXPECT_EQ(NearPairs(balls(5), 0.2, {}).at(centres).size(), 4U);
}

TEST(NearPairs, HoldEveryPairThatIsNearWhileBodiesMove) {
  for (const double reach : {0.0, 1.5}) {
    NearPairs near_pairs(balls(2), reach, {});
    Eigen::Matrix3Xd centres = row(2, 58.0);
    ASSERT_TRUE(near_pairs.at(centres).empty());
    while (centres(2, 1) > 8.0 + reach) {
      centres(2, 1) -= 0.3;
      near_pairs.at(centres);
    }
    EXPECT_EQ(near_pairs.at(centres).size(), 1U);
  }
}

TEST(NearPairs, ReachAcrossPeriodicFaces) {
  const auto centres = row(2, 95.0);
  EXPECT_TRUE(NearPairs(balls(2), 0.0, {}).at(centres).empty());
  EXPECT_EQ(NearPairs(balls(2), 0.0, {0, 0, 100}).at(centres).size(), 1U);
}

TEST(NearPairs, ListBodiesLongerThanThePeriodicBox) {
  const std::vector<Shape> shapes{ball, {ShapeKind::capsule, 4.0, 8.0}};
  EXPECT_TRUE(NearPairs(shapes, 0.0, {0, 0, 17}).longer_than_the_box().empty());
  EXPECT_EQ(NearPairs(shapes, 0.0, {0, 0, 15}).longer_than_the_box(), std::vector<int>{1});
}

}  // namespace
}  // namespace copepod
