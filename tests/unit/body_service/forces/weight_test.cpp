#include "forces/weight.hpp"

#include <gtest/gtest.h>

namespace copepod::body {
namespace {

TEST(Weight, VanishesForABodyAsDenseAsTheFluid) {
  EXPECT_EQ(buoyant_weight(6.0, 3.0, 2.0, {0, 0, -10}), Eigen::Vector3d::Zero());
}

TEST(Weight, PointsUpForALighterBody) {
  EXPECT_EQ(buoyant_weight(5.0, 3.0, 2.0, {0, 0, -10}), Eigen::Vector3d(0, 0, 10));
}

TEST(Weight, IsGravityAloneInVacuum) {
  EXPECT_EQ(buoyant_weight(5.0, 3.0, 0.0, {1, 2, -10}), Eigen::Vector3d(5, 10, -50));
}

}  // namespace
}  // namespace copepod::body
