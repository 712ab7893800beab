#include "bullet/bullet_world.hpp"

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "engine/engine_under_test.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {

MakeEngineWorld engine_under_test() {
  return [](const auto&... inputs) { return std::make_unique<BulletWorld>(inputs...); };
}

namespace {

TEST(BulletWorld, LeavesFixedAndPrescribedBodiesTheirMotion) {
  BodySpecification fixed = bead("fixed", {0, 0, 0});
  fixed.motion = MotionKind::fixed;
  BodySpecification belt = bead("belt", {20e-6, 0, 0});
  belt.motion = MotionKind::prescribed;
  belt.velocity_m_per_s = {0, 0, 0.5};
  belt.angular_velocity_rad_per_s = {0, 1e5, 0};
  const auto load = [](AppliedLoads& applied) { applied.hydrodynamic.force_N.setConstant(1e-3); };
  EngineBodySolver bullet = engine_solver(setup_of({fixed, belt}, 7.5e-10));
  RigidBodySolver own(setup_of({fixed, belt}, 7.5e-10, Integrator::semi_implicit_euler));
  const Kinematics theirs = advance(bullet, 1000, load);
  const Kinematics ours = advance(own, 1000, load);
  EXPECT_EQ(theirs.position_m, ours.position_m);
  EXPECT_EQ(theirs.velocity_m_per_s, ours.velocity_m_per_s);
  EXPECT_LT((theirs.orientation_wxyz - ours.orientation_wxyz).norm(), 1e-13);
}

}  // namespace
}  // namespace copepod::body
