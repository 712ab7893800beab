#include <gtest/gtest.h>

#include "config/placement/placement.hpp"

namespace copepod::coupler {
namespace {

TEST(RandomNumbers, AreThoseOfTheStandardsGenerator) {
  RandomNumbers random(5489);  // the 10000th number that the standard gives for this seed
  for (int i = 0; i < 9999; ++i) random.fraction();
  EXPECT_EQ(random.fraction(), 0x1p-53 * static_cast<double>(9981545732273789042ULL >> 11U));
}

TEST(RandomNumbers, OfOneSeedAreTheSame) {
  RandomNumbers first(3), second(3), other(4);
  const Eigen::Vector4d orientation = first.orientation();
  EXPECT_EQ(orientation, second.orientation());
  EXPECT_NE(orientation, other.orientation());
}

TEST(RandomNumbers, TurnEveryWay) {
  constexpr int samples = 20000;
  RandomNumbers random(1);
  Eigen::Vector4d mean = Eigen::Vector4d::Zero();
  Eigen::Matrix4d squares = Eigen::Matrix4d::Zero();
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector4d q = random.orientation();
    EXPECT_NEAR(q.norm(), 1.0, 1e-14);
    mean += q / samples;
    squares += q * q.transpose() / samples;
  }
  // Of points spread evenly over the sphere in four dimensions.
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.02);
  EXPECT_LT((squares - 0.25 * Eigen::Matrix4d::Identity()).cwiseAbs().maxCoeff(), 0.01);
}

TEST(RandomNumbers, PointIntoACone) {
  constexpr int samples = 20000;
  RandomNumbers random(1);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector3d direction = random.direction_about_z(0.5);
    EXPECT_NEAR(direction.norm(), 1.0, 1e-14);
    EXPECT_GE(direction.z(), 0.5);
    mean += direction / samples;
  }
  EXPECT_LT((mean - Eigen::Vector3d(0, 0, 0.75)).cwiseAbs().maxCoeff(), 0.01);  // evenly over the cap: z, too
  EXPECT_EQ(random.direction_about_z(1.0), Eigen::Vector3d(0, 0, 1));
}

}  // namespace
}  // namespace copepod::coupler
