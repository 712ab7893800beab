// Stops of hinges and sliders; docs/theory_bodies.md, (B34).
#include <cmath>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double limited_step_s = 1e-6;

JointSpecification limited(JointKind kind, int body_B, double lowest, double highest, const Eigen::Vector3d& axis) {
  JointSpecification joint{kind, 0, body_B};
  joint.axis = axis;
  joint.lowest = lowest;
  joint.highest = highest;
  return joint;
}

/// Angle of a body about y.
double turned(const Kinematics& state, Eigen::Index body) {
  return 2.0 * std::atan2(state.orientation_wxyz(2, body), state.orientation_wxyz(0, body));
}

TEST(JointLimit, HoldsASliderUnderALoadThatDoesNotEndAndLetsItGoAgain) {
  BodySetup setup = setup_of({bead("a", {0, 0, 0})}, limited_step_s);
  const double acceleration = 1.0;  // m/s²
  const double limit_m = 2e-9;      // reached after 63 steps
  const Eigen::Vector3d axis(0.6, 0, 0.8);
  for (const double sign : {-1.0, 1.0}) {
    setup.joints = {limited(JointKind::slider, -1, -limit_m, limit_m, axis)};
    RigidBodySolver solver(setup);
    const auto push = [&](double to) {
      return [&, to](AppliedLoads& applied) {
        applied.hydrodynamic.force_N.col(0) = to * acceleration * setup.bodies[0].mass_kg * axis;
      };
    };
    const Kinematics before = advance(solver, 60, push(sign));
    EXPECT_NEAR(before.position_m.col(0).dot(axis), sign * 0.5 * acceleration * std::pow(60 * limited_step_s, 2),
                1e-20);
    for (int i = 0; i < 5; ++i) {
      const Kinematics held = advance(solver, 20, push(sign));
      EXPECT_NEAR(held.position_m.col(0).dot(axis), sign * limit_m, 1e-23);
      EXPECT_NEAR(held.velocity_m_per_s.norm(), 0.0, 1e-18);
    }
    const Kinematics after = advance(solver, 30, push(-sign));
    EXPECT_NEAR(after.position_m.col(0).dot(axis), sign * (limit_m - 0.5 * acceleration * std::pow(30e-6, 2)), 1e-20);
  }
}

TEST(JointLimit, TurnsTwoBodiesIntoOneThatKeepsTheirAngularMomentum) {
  // On a common axis through both centres, only the first one turns, until it takes the second along.
  BodySetup setup = setup_of({capsule("a", {0, 0, 0}), bead("b", {0, 0, 0})}, limited_step_s);
  setup.bodies[0].angular_velocity_rad_per_s = {0, 300, 0};
  const auto inertia = [&setup](std::size_t body) {
    return inertia_tensor_kg_m2(setup.bodies[body].shape, setup.bodies[body].mass_kg)(0, 0);
  };
  setup.joints = {limited(JointKind::hinge, 1, -0.5, 0.25, {0, 1, 0})};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 2000);
  const double common = 300 * inertia(0) / (inertia(0) + inertia(1));
  EXPECT_NEAR(turned(end, 0) - turned(end, 1), 0.25, 1e-12);
  for (const Eigen::Index body : {0, 1}) {
    EXPECT_NEAR(end.angular_velocity_rad_per_s(1, body) / common, 1.0, 1e-12);
    EXPECT_NEAR(end.position_m.col(body).norm(), 0.0, 1e-18);
  }
}

TEST(JointLimit, EndsTheSwingOfAPendulumWithoutAddingEnergy) {
  // Let go level, its stop is 0.3 rad before the lowest point: it comes to rest there, pressed against it.
  BodySetup setup = setup_of({capsule("arm", {8e-6, 0, 0})}, limited_step_s);
  setup.bodies[0].orientation_wxyz = rotated({0, 1.5707963267948966, 0}, {1, 0, 0, 0});
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.joints = {limited(JointKind::hinge, -1, 0, 1.2707963267948966, {0, 1, 0})};
  setup.joints[0].anchor_A_m = {0, 0, -8e-6};
  RigidBodySolver solver(setup);
  Kinematics state;
  double highest_energy = 0.0;  // per mass
  for (int i = 0; i < 60; ++i) {
    state = advance(solver, 100);
    const double square =
        state.velocity_m_per_s.squaredNorm() +
        state.angular_velocity_rad_per_s.squaredNorm() * inertia_tensor_kg_m2(setup.bodies[0].shape, 1.0)(0, 0);
    highest_energy = std::max(highest_energy, 0.5 * square + 9.81 * state.position_m(2, 0));
  }
  EXPECT_LT(highest_energy, 1e-12 * 9.81 * 8e-6);
  EXPECT_NEAR(std::atan2(-state.position_m(2, 0), state.position_m(0, 0)), 1.2707963267948966, 1e-12);
  EXPECT_NEAR(state.angular_velocity_rad_per_s.norm(), 0.0, 1e-9);
}

/// Two beads on a slider along x, which turn about their centre of mass and move apart.
BodySetup turning_pair(double step_s, double apart_m_per_s) {
  BodySetup setup = setup_of({bead("a", {1, 0, 0}), bead("b", {-1, 0, 0})}, step_s);
  for (BodySpecification& body : setup.bodies) {
    body.shape.radius_m = 0.1;
    body.mass_kg = 1.0;
    body.angular_velocity_rad_per_s = {0, 0, 1};
    body.velocity_m_per_s = Eigen::Vector3d(0.5 * apart_m_per_s, 1, 0) * body.position_m.x();
  }
  setup.joints = {limited(JointKind::slider, 1, -0.1, 0.0, {1, 0, 0})};
  setup.joints[0].anchor_A_m = {-1, 0, 0};
  setup.joints[0].anchor_B_m = {1, 0, 0};
  return setup;
}

/// About z and the origin, of beads like these.
double angular_momentum(const Kinematics& state, const BodySetup& setup) {
  double sum = 0.0;
  for (Eigen::Index body = 0; body < state.position_m.cols(); ++body) {
    const BodySpecification& of = setup.bodies[static_cast<std::size_t>(body)];
    const Eigen::Vector3d x = state.position_m.col(body), v = state.velocity_m_per_s.col(body);
    sum += of.mass_kg * x.cross(v).z() +
           inertia_tensor_kg_m2(of.shape, of.mass_kg)(0, 0) * state.angular_velocity_rad_per_s(2, body);
  }
  return sum;
}

double kinetic_energy(const Kinematics& state, const BodySetup& setup) {
  double sum = 0.0;
  for (Eigen::Index body = 0; body < state.position_m.cols(); ++body) {
    const BodySpecification& of = setup.bodies[static_cast<std::size_t>(body)];
    sum += 0.5 * of.mass_kg * state.velocity_m_per_s.col(body).squaredNorm() +
           0.5 * inertia_tensor_kg_m2(of.shape, of.mass_kg)(0, 0) *
               state.angular_velocity_rad_per_s.col(body).squaredNorm();
  }
  return sum;
}

TEST(JointLimit, KeepsEnergyAndMomentaOfWhatItHolds) {
  for (const double step_s : {1e-2, 1e-3}) {
    const BodySetup setup = turning_pair(step_s, 0.0);
    RigidBodySolver solver(setup);
    Kinematics start;
    solver.kinematics(start);
    const Kinematics end = advance(solver, std::lround(20.0 / step_s));
    EXPECT_NEAR(angular_momentum(end, setup) / angular_momentum(start, setup), 1.0, 1e-8) << step_s;
    EXPECT_NEAR(kinetic_energy(end, setup) / kinetic_energy(start, setup), 1.0, 1e-8) << step_s;
    EXPECT_NEAR((end.position_m.col(0) - end.position_m.col(1)).norm(), 2.0, 1e-12) << step_s;
    EXPECT_NEAR((end.velocity_m_per_s.col(0) + end.velocity_m_per_s.col(1)).norm(), 0.0, 1e-12) << step_s;
  }
}

TEST(JointLimit, KeepsAngularMomentumInAnImpactToSecondOrderInTheStep) {
  const auto change = [](double step_s) {
    BodySetup setup = turning_pair(step_s, 0.3);
    setup.joints[0].highest = 0.0777;
    RigidBodySolver solver(setup);
    Kinematics start;
    solver.kinematics(start);
    const Kinematics end = advance(solver, std::lround(1.0 / step_s));
    EXPECT_NEAR((end.position_m.col(0) - end.position_m.col(1)).norm(), 2.0777, 1e-12);
    return std::abs(angular_momentum(end, setup) / angular_momentum(start, setup) - 1.0);
  };
  EXPECT_LT(change(1e-3), 1e-6);
  EXPECT_LT(change(1e-4), 1e-8);
}

TEST(JointLimit, LetsAPendulumWhoseBobItHoldsKeepItsEnergy) {
  BodySetup setup = setup_of({capsule("arm", {0, 0, -8e-6}), bead("bob", {0, 0, -20e-6})}, limited_step_s);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  for (BodySpecification& body : setup.bodies) {
    body.angular_velocity_rad_per_s = {0, 400, 0};
    body.velocity_m_per_s = body.angular_velocity_rad_per_s.cross(body.position_m);
  }
  JointSpecification hook{JointKind::hinge, 0, -1, {0, 0, 8e-6}};
  hook.axis = {0, 1, 0};
  JointSpecification rail = limited(JointKind::slider, 0, -1e-6, 0.0, {0, 0, -1});
  rail.body_A = 1;
  rail.anchor_B_m = {0, 0, -12e-6};
  setup.joints = {hook, rail};
  const auto energy = [&](const Kinematics& state) {
    double sum = kinetic_energy(state, setup);
    for (const Eigen::Index body : {0, 1})
      sum += 9.81 * setup.bodies[static_cast<std::size_t>(body)].mass_kg * (state.position_m(2, body) + 20e-6);
    return sum;
  };
  RigidBodySolver solver(setup);
  Kinematics start;
  solver.kinematics(start);
  const Kinematics end = advance(solver, 50000);  // some 8 periods
  EXPECT_NEAR(energy(end) / energy(start), 1.0, 1e-6);
  EXPECT_NEAR((end.position_m.col(1) - end.position_m.col(0)).norm(), 12e-6, 1e-18);
}

TEST(JointLimit, IsRefusedWhereThereIsNoMotionOrTheStartIsBeyondIt) {
  const auto refusal_of = [](const JointSpecification& joint) {
    BodySetup setup = setup_of({bead("a", {0, 0, 0})}, limited_step_s);
    setup.joints = {joint};
    return reason_of<CaseError>([&] { const RigidBodySolver solver(setup); });
  };
  EXPECT_TRUE(contains(refusal_of(limited(JointKind::ball, -1, -1, 1, {0, 0, 1})), "only hinges"));
  EXPECT_TRUE(contains(refusal_of(limited(JointKind::slider, -1, 1, 2, {0, 0, 1})), "leave its start out"));
  EXPECT_TRUE(contains(refusal_of(limited(JointKind::slider, -1, -1, NAN, {0, 0, 1})), "leave its start out"));
  EXPECT_TRUE(contains(refusal_of(limited(JointKind::hinge, -1, -3.1, 1, {0, 0, 1})), "wider than 3"));

  BodySetup driven = setup_of({bead("a", {0, 0, 0})}, limited_step_s);
  driven.joints = {limited(JointKind::slider, -1, -1, 1, {0, 0, 1})};
  driven.actuators = {actuator_on(0, ActuatorKind::joint_motion, {0, 0, 1})};
  driven.actuators[0].joint = 0;
  EXPECT_TRUE(contains(reason_of<CaseError>([&] { const RigidBodySolver solver(driven); }), "would not obey"));
}

}  // namespace
}  // namespace copepod::body
