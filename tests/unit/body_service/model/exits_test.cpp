#include "model/exits.hpp"

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "rigid_body_solver.hpp"
#include "temporary_folder.hpp"

namespace copepod::body {
namespace {

constexpr double step_s = 1e-6;

/// Beads of 4 µm before an exit at x = 100 µm, three of which move by 1 µm per step, one of these on a spring.
BodySetup leaving(bool contacts) {
  BodySetup setup =
      setup_of({bead("near", {94.5e-6, 0, 0}), bead("far", {80e-6, 30e-6, 0}), bead("held", {94e-6, 60e-6, 0}),
                bead("anchor", {94e-6, 90e-6, 0}), bead("fixed", {98e-6, 150e-6, 0})},
               step_s);
  for (std::size_t body = 0; body < 3; ++body) setup.bodies[body].velocity_m_per_s = {1.0, 0, 0};
  setup.bodies[0].angular_velocity_rad_per_s = {0, 1e3, 0};
  setup.bodies[4].motion = MotionKind::fixed;
  setup.springs = {{.body_A = 2, .body_B = 3, .stiffness_N_per_m = 1e-6, .rest_length_m = 30e-6}};
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.walls = {{.point_m = {100e-6, 0, 0}, .normal = {-1, 0, 0}, .removes_bodies = true}};
  if (contacts) setup.contact = {.stiffness_N_per_m = 1.0};
  return setup;
}

TEST(Exits, TakeABodyWhoseBallReachesThemAndNoOther) {
  for (const bool contacts : {false, true}) {
    const BodySetup setup = leaving(contacts);
    RigidBodySolver solver(setup);
    EXPECT_LT(advance(solver, 1).position_m(0, 0), 96e-6);
    const Kinematics leaves = advance(solver, 1);  // would be at 96.5 µm
    EXPECT_GT(leaves.position_m(0, 0), 100e-6 + 8e-6);
    EXPECT_DOUBLE_EQ(leaves.velocity_m_per_s(0, 0), 1.0);  // of the fluid that takes its place
    EXPECT_EQ(leaves.angular_velocity_rad_per_s.col(0), Eigen::Vector3d(0, 0, 0));

    const Kinematics rests = advance(solver, 20);
    EXPECT_EQ(rests.position_m.col(0), leaves.position_m.col(0));
    EXPECT_EQ(rests.velocity_m_per_s.col(0), Eigen::Vector3d(0, 0, 0));
    EXPECT_GT((rests.position_m.col(1) - rests.position_m.col(0)).norm(), 16e-6);
    EXPECT_GT(rests.position_m(0, 1), 108e-6);
    EXPECT_GT(rests.position_m(0, 2), 100e-6);  // held by a spring
    EXPECT_LT(rests.position_m(0, 2), 120e-6);
    EXPECT_EQ(rests.position_m(0, 4), 98e-6);
  }
}

TEST(Exits, AreRememberedByASavedState) {
  const TemporaryFolder folder;
  const BodySetup setup = leaving(true);
  RigidBodySolver solver(setup), resumed(setup);
  advance(solver, 10);
  solver.save(folder.path("state"));
  resumed.restore(folder.path("state"));
  const Kinematics expected = advance(solver, 20);
  EXPECT_EQ(advance(resumed, 20).position_m, expected.position_m);
}

}  // namespace
}  // namespace copepod::body
