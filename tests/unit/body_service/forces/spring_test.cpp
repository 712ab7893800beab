#include "forces/spring.hpp"

#include <gtest/gtest.h>

namespace copepod::body {
namespace {

TEST(Spring, PullsItsEndsTogetherWhenStretched) {
  const SpringLaw law{3.0, 0.0, 2.0};
  const Eigen::Vector3d f = spring_force(law, {0, 0, 5}, {0, 0, 0});
  EXPECT_EQ(f, Eigen::Vector3d(0, 0, 9));
}

TEST(Spring, PushesItsEndsApartWhenCompressed) {
  const SpringLaw law{3.0, 0.0, 2.0};
  EXPECT_EQ(spring_force(law, {1, 0, 0}, {0, 0, 0}), Eigen::Vector3d(-3, 0, 0));
}

TEST(Spring, DampsTheRateOfItsLength) {
  const SpringLaw law{0.0, 7.0, 2.0};
  EXPECT_EQ(spring_force(law, {0, 4, 0}, {0, 2, 0}), Eigen::Vector3d(0, 14, 0));
}

TEST(Spring, DoesNotBrakeMotionAcrossIt) {
  const SpringLaw law{0.0, 7.0, 2.0};
  EXPECT_EQ(spring_force(law, {0, 4, 0}, {3, 0, -5}), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace copepod::body
