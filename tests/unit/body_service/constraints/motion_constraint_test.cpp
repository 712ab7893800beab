#include "constraints/motion_constraint.hpp"

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"

namespace copepod::body {
namespace {

const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 2) / 3.0;

BodySpecification moving(MotionKind motion, const Eigen::Vector3d& velocity) {
  BodySpecification body = bead("a", {0, 0, 0});
  body.motion = motion;
  body.axis = axis;
  body.velocity_m_per_s = velocity;
  return body;
}

TEST(MotionConstraint, LeavesOnlyTheLoadsAlongTheAxis) {
  Eigen::Vector3d force(9, 0, 0);
  Eigen::Vector3d torque(0, 9, -9);
  constrain_loads(MotionKind::axis, axis, force, torque);
  EXPECT_TRUE(force.isApprox(3.0 * axis, 1e-15));
  EXPECT_LT(torque.norm(), 1e-15);
}

TEST(MotionConstraint, BalancesAllLoadsOnFixedAndPrescribedBodies) {
  for (const MotionKind motion : {MotionKind::fixed, MotionKind::prescribed}) {
    Eigen::Vector3d force(1, 2, 3);
    Eigen::Vector3d torque(4, 5, 6);
    constrain_loads(motion, axis, force, torque);
    EXPECT_TRUE(force.isZero(0.0));
    EXPECT_TRUE(torque.isZero(0.0));
  }
}

TEST(MotionConstraint, LeavesFreeBodiesAlone) {
  Eigen::Vector3d force(1, 2, 3);
  Eigen::Vector3d torque(4, 5, 6);
  constrain_loads(MotionKind::free, axis, force, torque);
  EXPECT_EQ(force, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(torque, Eigen::Vector3d(4, 5, 6));
}

TEST(MotionConstraint, RefusesAVelocityOffTheAxis) {
  EXPECT_TRUE(constrained_velocities(moving(MotionKind::axis, 5.0 * axis)).linear_m_per_s.isApprox(5.0 * axis));
  const std::string reason = reason_of<CaseError>([] { constrained_velocities(moving(MotionKind::axis, {1, 0, 0})); });
  EXPECT_TRUE(contains(reason, "velocity_m_per_s points off its axis"));
  BodySpecification turning = moving(MotionKind::axis, {0, 0, 0});
  turning.angular_velocity_rad_per_s = {0, 1, 0};
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { constrained_velocities(turning); }),
                       "angular_velocity_rad_per_s points off its axis"));
}

TEST(MotionConstraint, RefusesAnAxisThatIsNoDirection) {
  BodySpecification body = moving(MotionKind::axis, {0, 0, 0});
  body.axis = {0, 0, 2};
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { constrained_velocities(body); }), "axis has length 2"));
}

TEST(MotionConstraint, RefusesAFixedBodyThatMoves) {
  EXPECT_TRUE(contains(reason_of<CaseError>([] {
                         constrained_velocities(moving(MotionKind::fixed, {1, 0, 0}));
                       }),
                       "fixed never moves"));
  EXPECT_TRUE(constrained_velocities(moving(MotionKind::fixed, {0, 0, 0})).linear_m_per_s.isZero(0.0));
}

}  // namespace
}  // namespace copepod::body
