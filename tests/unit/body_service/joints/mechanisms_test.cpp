// Mechanisms against closed forms and a reference integration; docs/decisions/joints.md.
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "geometry/rotation.hpp"
#include "joints/joints.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double g_m_per_s2 = 9.81;
constexpr double half_m = 8e-6;  ///< from the centre of a link to its end

JointSpecification joint_of(JointKind kind, int body_A, int body_B, const Eigen::Vector3d& anchor_A_m,
                            const Eigen::Vector3d& anchor_B_m, const Eigen::Vector3d& axis = Eigen::Vector3d::UnitY()) {
  return {kind, body_A, body_B, anchor_A_m, anchor_B_m, axis};
}

/// A capsule from `from_m` to `to_m` in the plane y = 0, its z axis pointing back to `from_m`.
BodySpecification link(const std::string& name, const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
  BodySpecification body = capsule(name, 0.5 * (from_m + to_m));
  const Eigen::Vector3d back = from_m - to_m;
  body.orientation_wxyz = rotated({0, std::atan2(back.x(), back.z()), 0}, {1, 0, 0, 0});
  return body;
}

Eigen::Vector3d moments() { return inertia_tensor_kg_m2(capsule("", {0, 0, 0}).shape, 5.44e-13).diagonal(); }

/// Angle of a link from the vertical, positive towards +x at its lower end.
double angle_of(const Kinematics& state, int body) {
  const Eigen::Vector3d up = z_axis(state.orientation_wxyz.col(body));
  return std::atan2(-up.x(), up.z());
}

Eigen::Vector3d end_at(double angle_rad, double length_m) {
  return {length_m * std::sin(angle_rad), 0, -length_m * std::cos(angle_rad)};
}

double kinetic_energy_J(const Kinematics& state) {
  double energy_J = 0.0;
  for (Eigen::Index body = 0; body < state.bodies(); ++body) {
    const Eigen::Vector3d w = state.angular_velocity_rad_per_s.col(body);
    const double spin = w.dot(z_axis(state.orientation_wxyz.col(body)));
    energy_J += 0.5 * 5.44e-13 * state.velocity_m_per_s.col(body).squaredNorm() +
                0.5 * (moments()[0] * (w.squaredNorm() - spin * spin) + moments()[2] * spin * spin);
  }
  return energy_J;
}

double energy_J(const Kinematics& state) {
  return kinetic_energy_J(state) + 5.44e-13 * g_m_per_s2 * state.position_m.row(2).sum();
}

/// `links` capsules that hang from the origin, each at its angle.
BodySetup hanging(const std::vector<double>& angles_rad, double step_s, JointKind kind = JointKind::hinge) {
  BodySetup setup = setup_of({}, step_s);
  setup.gravity_m_per_s2 = {0, 0, -g_m_per_s2};
  Eigen::Vector3d top_m = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < angles_rad.size(); ++i) {
    const Eigen::Vector3d bottom_m = top_m + end_at(angles_rad[i], 2.0 * half_m);
    setup.bodies.push_back(link("link " + std::to_string(i), top_m, bottom_m));
    const auto body = static_cast<int>(i);
    setup.joints.push_back(i == 0 ? joint_of(kind, 0, -1, {0, 0, half_m}, {0, 0, 0})
                                  : joint_of(kind, body, body - 1, {0, 0, half_m}, {0, 0, -half_m}));
    top_m = bottom_m;
  }
  return setup;
}

/// T = 4 K(sin(θ₀/2)) √(I/(m g d)), K the complete elliptic integral of the first kind
double period_s(double amplitude_rad) {
  const double inertia_kg_m2 = moments()[0] + 5.44e-13 * half_m * half_m;
  return 4.0 * std::comp_ellint_1(std::sin(0.5 * amplitude_rad)) *
         std::sqrt(inertia_kg_m2 / (5.44e-13 * g_m_per_s2 * half_m));
}

double error_after_a_quarter(std::int64_t steps) {
  constexpr double amplitude_rad = 1.2;
  RigidBodySolver solver(hanging({amplitude_rad}, 0.25 * period_s(amplitude_rad) / static_cast<double>(steps)));
  return std::abs(angle_of(advance(solver, steps), 0));
}

TEST(PhysicalPendulum, HasThePeriodOfTheEllipticIntegralToFourthOrder) {
  // At a quarter of the period the angle vanishes, and its error is that of the phase.
  EXPECT_LT(error_after_a_quarter(100), 1e-8);
  const double order = std::log2(error_after_a_quarter(20) / error_after_a_quarter(40));
  EXPECT_NEAR(order, 4.0, 0.4);
}

/// d/dt of (θ₁, θ₂, θ̇₁, θ̇₂) of two links, by Lagrange's equations.
Eigen::Vector4d double_pendulum(const Eigen::Vector4d& y) {
  const double m = 5.44e-13;
  const double l = half_m;
  const double I = moments()[0];
  const double sine = std::sin(y[0] - y[1]);
  Eigen::Matrix2d mass;
  mass << I + 5 * m * l * l, 2 * m * l * l * std::cos(y[0] - y[1]), 2 * m * l * l * std::cos(y[0] - y[1]),
      I + m * l * l;
  const Eigen::Vector2d right(-2 * m * l * l * sine * y[3] * y[3] - 3 * m * g_m_per_s2 * l * std::sin(y[0]),
                              2 * m * l * l * sine * y[2] * y[2] - m * g_m_per_s2 * l * std::sin(y[1]));
  const Eigen::Vector2d acceleration = mass.inverse() * right;
  return {y[2], y[3], acceleration[0], acceleration[1]};
}

Eigen::Vector4d reference_double_pendulum(Eigen::Vector4d y, double h, int steps) {
  for (int i = 0; i < steps; ++i) {
    const Eigen::Vector4d k1 = double_pendulum(y);
    const Eigen::Vector4d k2 = double_pendulum(y + 0.5 * h * k1);
    const Eigen::Vector4d k3 = double_pendulum(y + 0.5 * h * k2);
    const Eigen::Vector4d k4 = double_pendulum(y + h * k3);
    y += h / 6.0 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  return y;
}

TEST(DoublePendulum, FollowsLagrangesEquationsAndKeepsItsEnergy) {
  const double step_s = period_s(0.1) / 1000;
  RigidBodySolver solver(hanging({2.0, 1.0}, step_s));
  Kinematics start;
  solver.kinematics(start);
  const Kinematics end = advance(solver, 2000);
  const Eigen::Vector4d reference = reference_double_pendulum({2.0, 1.0, 0, 0}, 0.1 * step_s, 20000);
  const auto difference = [](double a, double b) { return std::remainder(a - b, 2 * std::numbers::pi); };
  // Two integrators of fourth order; the motion stretches errors by some 10 over these two periods.
  EXPECT_NEAR(difference(angle_of(end, 0), reference[0]), 0.0, 1e-7);
  EXPECT_NEAR(difference(angle_of(end, 1), reference[1]), 0.0, 1e-7);
  EXPECT_NEAR(energy_J(end), energy_J(start), 1e-8 * 5.44e-13 * g_m_per_s2 * half_m);
}

TEST(SliderCrank, HasThePistonAtItsClosedFormPlaceAndKeepsItsEnergy) {
  constexpr double crank_m = 16e-6;
  constexpr double rod_m = 48e-6;
  constexpr double start_rad = 0.4;
  const auto piston_at = [](double angle) {
    const double across = crank_m * std::sin(angle);
    return crank_m * std::cos(angle) + std::sqrt(rod_m * rod_m - across * across);
  };
  const Eigen::Vector3d pin_m(crank_m * std::cos(start_rad), 0, crank_m * std::sin(start_rad));
  const Eigen::Vector3d piston_m(piston_at(start_rad), 0, 0);
  const double speed = 1e3;  // rad/s, of the crank; the start shares its momentum with rod and piston
  BodySetup setup = setup_of({link("crank", {0, 0, 0}, pin_m), link("rod", pin_m, piston_m), bead("piston", piston_m)},
                             2e-3 * 2 * std::numbers::pi / speed);
  setup.bodies[0].angular_velocity_rad_per_s = {0, -speed, 0};
  setup.joints = {joint_of(JointKind::hinge, 0, -1, {0, 0, crank_m / 2}, {0, 0, 0}),
                  joint_of(JointKind::hinge, 1, 0, {0, 0, rod_m / 2}, {0, 0, -crank_m / 2}),
                  joint_of(JointKind::hinge, 2, 1, {0, 0, 0}, {0, 0, -rod_m / 2}),
                  joint_of(JointKind::slider, 2, -1, {0, 0, 0}, piston_m, Eigen::Vector3d::UnitX())};
  RigidBodySolver solver(setup);
  const double energy_at_start_J = kinetic_energy_J(advance(solver, 0));
  double turned_rad = 0.0;
  double before_rad = start_rad;
  for (int sample = 0; sample < 240; ++sample) {
    const Kinematics state = advance(solver, 50);
    const Eigen::Vector3d back = z_axis(state.orientation_wxyz.col(0));
    const double angle = std::atan2(-back.z(), -back.x());
    turned_rad += std::remainder(angle - before_rad, 2 * std::numbers::pi);
    before_rad = angle;
    ASSERT_NEAR(state.position_m(0, 2), piston_at(angle), 1e-16);
    ASSERT_NEAR(kinetic_energy_J(state), energy_at_start_J, 1e-8 * energy_at_start_J);
  }
  EXPECT_GT(turned_rad, 2 * std::numbers::pi) << "a full turn, with both dead centres";
}

TEST(FourBar, TurnsUniformlyAsAParallelogram) {
  // Equal cranks about y = 0; by symmetry the energy is a multiple of the angular velocity squared, which is constant.
  constexpr double crank_m = 16e-6;
  constexpr double base_m = 40e-6;
  constexpr double speed = 1e3;
  constexpr double start_rad = 0.5;
  const Eigen::Vector3d base(base_m, 0, 0);
  const Eigen::Vector3d pin = end_at(start_rad, crank_m);
  BodySetup setup =
      setup_of({link("crank", {0, 0, 0}, pin), link("rocker", base, base + pin), link("coupler", pin, base + pin)},
               1e-3 / speed);
  const Eigen::Vector3d w(0, -speed, 0);
  for (const int i : {0, 1}) {
    setup.bodies[i].angular_velocity_rad_per_s = w;
    setup.bodies[i].velocity_m_per_s = 0.5 * w.cross(pin);
  }
  setup.bodies[2].velocity_m_per_s = w.cross(pin);
  setup.joints = {joint_of(JointKind::hinge, 0, -1, {0, 0, crank_m / 2}, {0, 0, 0}),
                  joint_of(JointKind::hinge, 1, -1, {0, 0, crank_m / 2}, base),
                  joint_of(JointKind::hinge, 2, 0, {0, 0, base_m / 2}, {0, 0, -crank_m / 2}),
                  joint_of(JointKind::hinge, 2, 1, {0, 0, -base_m / 2}, {0, 0, -crank_m / 2})};
  RigidBodySolver solver(setup);
  const Kinematics state = advance(solver, 600);
  const double angle = start_rad + 0.6;
  EXPECT_NEAR(angle_of(state, 0), angle, 1e-10);
  EXPECT_NEAR(angle_of(state, 1), angle, 1e-10);
  EXPECT_LT((state.position_m.col(2) - (0.5 * base + end_at(angle, crank_m))).norm(), 1e-10 * crank_m);
}

TEST(Chain, OfThirtyCapsulesSwingsWithoutLosingEnergy) {
  std::vector<double> angles(30);
  for (std::size_t i = 0; i < angles.size(); ++i) angles[i] = 1.0 - 0.03 * static_cast<double>(i);
  RigidBodySolver solver(hanging(angles, period_s(0.1) / 500, JointKind::ball));
  Kinematics start;
  solver.kinematics(start);
  const Kinematics end = advance(solver, 500);
  EXPECT_GT(kinetic_energy_J(end), 1e-3 * std::abs(energy_J(start)));
  EXPECT_NEAR(energy_J(end), energy_J(start), 1e-6 * std::abs(energy_J(start)));
}

}  // namespace
}  // namespace copepod::body
