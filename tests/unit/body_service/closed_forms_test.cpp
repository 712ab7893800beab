// Motions with a known formula: free fall, buoyant rise, spring oscillation, prescribed and axial motion.

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "geometry/rotation.hpp"
#include "model/body_model.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

TEST(ClosedForms, FreeFall) {
  BodySpecification body = bead("stone", {1e-5, 0, 1e-3});
  body.velocity_m_per_s = {0.1, 0, 0.2};
  BodySetup setup = setup_of({body}, 1e-4);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 1000);
  const double t = 0.1;
  EXPECT_NEAR(end.position_m(0, 0), 1e-5 + 0.1 * t, 1e-14);
  EXPECT_NEAR(end.position_m(2, 0), 1e-3 + 0.2 * t - 0.5 * 9.81 * t * t, 1e-14);
  EXPECT_NEAR(end.velocity_m_per_s(2, 0), 0.2 - 9.81 * t, 1e-12);
}

TEST(ClosedForms, BuoyantRise) {
  BodySetup setup = setup_of({capsule("float", {0, 0, 0})}, 1e-4);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.fluid_density_kg_per_m3 = 1360.0;
  const double volume = std::numbers::pi * 16e-12 * 8e-6 + 4.0 / 3.0 * std::numbers::pi * 64e-18;
  const double acceleration = (1360.0 * volume / 5.44e-13 - 1.0) * 9.81;
  ASSERT_GT(acceleration, 0.0);
  RigidBodySolver solver(setup);
  const Kinematics end = advance(solver, 1000);
  EXPECT_NEAR(end.position_m(2, 0), 0.5 * acceleration * 0.01, 1e-13);
}

TEST(ClosedForms, DampedSpringOscillation) {
  // Relative motion: m ξ'' + γ ξ' + k ξ = 0 with the reduced mass m; the centre of mass moves uniformly.
  BodySpecification light = bead("light", {0, 0, 0});
  BodySpecification heavy = bead("heavy", {0, 0, 25e-6});
  heavy.mass_kg = 3.0 * light.mass_kg;
  light.velocity_m_per_s = heavy.velocity_m_per_s = {0, 0, 0.01};
  SpringSpecification spring;
  spring.body_B = 1;
  spring.stiffness_N_per_m = 1.72965;
  spring.damping_N_s_per_m = 1.57237e-7;
  spring.rest_length_m = 24e-6;
  const double reduced_kg = 0.75 * light.mass_kg;
  const double decay = spring.damping_N_s_per_m / (2.0 * reduced_kg);
  const double frequency = std::sqrt(spring.stiffness_N_per_m / reduced_kg - decay * decay);

  const double step_s = 1e-9;
  BodySetup setup = setup_of({light, heavy}, step_s);
  setup.springs = {spring};
  RigidBodySolver solver(setup);
  for (int period_part = 1; period_part <= 20; ++period_part) {
    const Kinematics state = advance(solver, 400);
    const double t = 400 * step_s * period_part;
    const double expected =
        1e-6 * std::exp(-decay * t) * (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t));
    EXPECT_NEAR(state.position_m(2, 1) - state.position_m(2, 0) - 24e-6, expected, 1e-16) << "at " << t;
    EXPECT_NEAR(0.25 * state.position_m(2, 0) + 0.75 * state.position_m(2, 1), 18.75e-6 + 0.01 * t, 1e-18);
  }
}

TEST(ClosedForms, PrescribedMotionIgnoresAllLoads) {
  BodySpecification body = capsule("propeller", {0, 0, 0});
  body.motion = MotionKind::prescribed;
  body.orientation_wxyz = Eigen::Vector4d(0.8, 0.3, -0.4, 0.2).normalized();
  body.velocity_m_per_s = {0.1, -0.2, 0.3};
  body.angular_velocity_rad_per_s = {20.0, -10.0, 30.0};
  BodySetup setup = setup_of({body, bead("pulling", {1e-3, 0, 0})}, 1e-4);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.springs.emplace_back();
  setup.springs[0].body_B = 1;
  setup.springs[0].stiffness_N_per_m = 1e-9;
  setup.actuators = {actuator_on(0, ActuatorKind::world_force, {0, 0, 1}),
                     actuator_on(0, ActuatorKind::body_torque, {0, 0, 1})};
  RigidBodySolver solver(setup);
  const Kinematics end = advance(
      solver, 1000,
      [](AppliedLoads& applied) {
        applied.hydrodynamic.force_N.setConstant(1e-10);
        applied.hydrodynamic.torque_N_m.setConstant(1e-16);
        applied.actuation.setConstant(1e-10);
      },
      2);
  EXPECT_EQ(end.velocity_m_per_s.col(0), body.velocity_m_per_s);
  EXPECT_EQ(end.angular_velocity_rad_per_s.col(0), body.angular_velocity_rad_per_s);
  EXPECT_TRUE(end.position_m.col(0).isApprox(0.1 * body.velocity_m_per_s, 1e-12));
  const Eigen::Vector4d turned = rotated(0.1 * body.angular_velocity_rad_per_s, body.orientation_wxyz);
  EXPECT_TRUE(end.orientation_wxyz.col(0).isApprox(turned, 1e-10));
}

TEST(ClosedForms, FixedBodiesKeepEveryBit) {
  constexpr int bodies = 200;
  std::mt19937 random(1);
  std::normal_distribution<double> number;
  BodySetup setup = setup_of({}, 1e-4);
  for (int i = 0; i < bodies; ++i) {
    BodySpecification body = capsule("wall", {1e-4 * i, 0.2, 0.3});
    body.motion = MotionKind::fixed;
    body.orientation_wxyz << number(random), number(random), number(random), number(random);
    body.orientation_wxyz.normalize();
    setup.bodies.push_back(body);
  }
  for (const Integrator integrator : {Integrator::runge_kutta_4, Integrator::semi_implicit_euler}) {
    setup.integrator = integrator;
    RigidBodySolver solver(setup);
    Kinematics start;
    solver.kinematics(start);
    const Kinematics end = advance(solver, 20, [](AppliedLoads& applied) {
      applied.hydrodynamic.force_N.setConstant(1.0);
      applied.hydrodynamic.torque_N_m.setConstant(1.0);
    });
    EXPECT_EQ(end.position_m, start.position_m);
    EXPECT_EQ(end.orientation_wxyz, start.orientation_wxyz);
    EXPECT_TRUE(end.velocity_m_per_s.isZero(0.0));
  }
}

TEST(ClosedForms, AxialMotionTakesTheLoadsAlongTheAxisOnly) {
  BodySpecification body = capsule("screw", {0, 0, 0});
  body.motion = MotionKind::axis;
  body.axis = Eigen::Vector3d(1, 2, 2) / 3.0;
  body.orientation_wxyz = Eigen::Vector4d(0.8, 0.3, -0.4, 0.2).normalized();
  body.angular_velocity_rad_per_s = 5.0 * body.axis;
  const Eigen::Vector3d force(3e-12, 0, 1e-12);
  const Eigen::Vector3d torque(2e-22, 1e-22, -3e-23);
  RigidBodySolver solver(setup_of({body}, 1e-4));
  const Kinematics end = advance(solver, 1000, [&](AppliedLoads& applied) {
    applied.hydrodynamic.force_N.col(0) = force;
    applied.hydrodynamic.torque_N_m.col(0) = torque;
  });
  const double t = 0.1;
  const Eigen::Matrix3d R_WB = rotation_matrix(body.orientation_wxyz);
  const Eigen::Matrix3d inertia_W = R_WB * inertia_tensor_kg_m2(body.shape, body.mass_kg) * R_WB.transpose();
  const double acceleration = body.axis.dot(force) / body.mass_kg;
  const double angular_acceleration = body.axis.dot(torque) / body.axis.dot(inertia_W * body.axis);
  const double angle = 5.0 * t + 0.5 * angular_acceleration * t * t;
  EXPECT_TRUE(end.position_m.col(0).isApprox(0.5 * acceleration * t * t * body.axis, 1e-12));
  EXPECT_TRUE(end.angular_velocity_rad_per_s.col(0).isApprox((5.0 + angular_acceleration * t) * body.axis, 1e-12));
  EXPECT_TRUE(end.orientation_wxyz.col(0).isApprox(rotated(angle * body.axis, body.orientation_wxyz), 1e-10));
  EXPECT_GT(std::abs(angular_acceleration * t), 0.01) << "the torque would not be tested";
}

}  // namespace
}  // namespace copepod::body
