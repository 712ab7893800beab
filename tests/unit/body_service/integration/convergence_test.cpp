// Orders of convergence of both integrators, measured on a tumbling, driven, damped pair of bodies.

#include <cmath>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double duration_s = 2.0;

/// A capsule and a sphere of order-one size, tied together off their centres: translation, rotation,
/// gyroscopic term, anchors, damping, gravity and every kind of actuator take part.
BodySetup tumbling_pair(double step_s, Integrator integrator) {
  BodySpecification rod = capsule("rod", {0, 0, 0});
  rod.shape = {ShapeKind::capsule, 0.2, 1.0};
  rod.mass_kg = 1.0;
  rod.orientation_wxyz = Eigen::Vector4d(0.9, 0.1, -0.3, 0.2).normalized();
  rod.angular_velocity_rad_per_s = {1.0, 2.0, 3.0};
  BodySpecification ball = bead("ball", {3, 0, 0});
  ball.shape.radius_m = 0.3;
  ball.mass_kg = 0.7;
  ball.velocity_m_per_s = {0, 0.5, 0};

  BodySetup setup = setup_of({rod, ball}, step_s, integrator);
  setup.gravity_m_per_s2 = {0, 0.1, -0.2};
  SpringSpecification spring;
  spring.body_B = 1;
  spring.stiffness_N_per_m = 4.0;
  spring.damping_N_s_per_m = 0.3;
  spring.rest_length_m = 2.0;
  spring.anchor_A_m = {0.1, 0.0, 0.6};
  spring.anchor_B_m = {0.0, 0.3, 0.0};
  setup.springs = {spring};
  setup.actuators = {pair_force(0, 1), actuator_on(0, ActuatorKind::body_force, {0.6, 0, 0.8}),
                     actuator_on(0, ActuatorKind::body_torque, {0, 1, 0}),
                     actuator_on(1, ActuatorKind::world_force, {0.6, 0, 0.8}),
                     actuator_on(1, ActuatorKind::world_torque, {1, 0, 0})};
  setup.actuators[0].anchor_A_m = {0, 0.1, -0.4};
  return setup;
}

Kinematics end_state(int steps, Integrator integrator) {
  const double step_s = duration_s / steps;
  RigidBodySolver solver(tumbling_pair(step_s, integrator));
  const auto nodes = solver.driving_nodes();
  return advance(
      solver, steps,
      [&](AppliedLoads& applied) {
        for (std::size_t node = 0; node < nodes.size(); ++node) {
          const double time_s = (static_cast<double>(applied.hydrodynamic.step) + nodes[node]) * step_s;
          applied.actuation.col(static_cast<Eigen::Index>(node)) << std::sin(3.0 * time_s), 0.3, 0.1 * std::cos(time_s),
              0.5, 0.05;
        }
      },
      5);
}

double distance(const Kinematics& a, const Kinematics& b) {
  return (a.position_m - b.position_m).norm() + (a.orientation_wxyz - b.orientation_wxyz).norm() +
         (a.velocity_m_per_s - b.velocity_m_per_s).norm() +
         (a.angular_velocity_rad_per_s - b.angular_velocity_rad_per_s).norm();
}

const Kinematics& exact() {
  static const Kinematics state = end_state(8192, Integrator::runge_kutta_4);
  return state;
}

double measured_order(int steps, Integrator integrator) {
  const double coarse = distance(end_state(steps, integrator), exact());
  const double fine = distance(end_state(2 * steps, integrator), exact());
  EXPECT_GT(fine, 0.0);
  return std::log2(coarse / fine);
}

TEST(Convergence, OfRungeKutta4IsFourthOrder) {
  EXPECT_NEAR(measured_order(128, Integrator::runge_kutta_4), 4.0, 0.15);
  EXPECT_NEAR(measured_order(256, Integrator::runge_kutta_4), 4.0, 0.1);
}

TEST(Convergence, OfSemiImplicitEulerIsFirstOrder) {
  EXPECT_NEAR(measured_order(2048, Integrator::semi_implicit_euler), 1.0, 0.1);
  EXPECT_NEAR(measured_order(4096, Integrator::semi_implicit_euler), 1.0, 0.05);
}

TEST(Convergence, LeadsBothIntegratorsToTheSameMotion) {
  EXPECT_LT(distance(end_state(65536, Integrator::semi_implicit_euler), exact()), 5e-3);
}

}  // namespace
}  // namespace copepod::body
