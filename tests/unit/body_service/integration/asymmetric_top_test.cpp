// Torque-free rotation of a body with three different moments, whose principal axes are not those of its frame.

#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "geometry/rotation.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

const Eigen::Vector3d moments_kg_m2(1.0, 2.0, 2.5);
const Eigen::Matrix3d principal_axes = Eigen::Quaterniond(0.5, 0.1, -0.7, 0.3).normalized().toRotationMatrix();

/// @param w_rad_per_s  about the principal axes
BodySpecification top(const Eigen::Vector3d& w_rad_per_s) {
  BodySpecification body = bead("top", {0, 0, 0});
  body.shape.radius_m = 1.0;
  body.mass_kg = 1.0;
  const Eigen::Matrix3d I = principal_axes * moments_kg_m2.asDiagonal() * principal_axes.transpose();
  body.inertia_kg_m2 = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  body.orientation_wxyz = Eigen::Vector4d(0.8, 0.3, -0.4, 0.2).normalized();
  body.angular_velocity_rad_per_s = rotation_matrix(body.orientation_wxyz) * principal_axes * w_rad_per_s;
  return body;
}

Eigen::Vector3d about_principal_axes(const Eigen::Vector4d& q_WB, const Eigen::Vector3d& w_W) {
  return principal_axes.transpose() * rotation_matrix(q_WB).transpose() * w_W;
}

/// Angular velocity about the principal axes after some steps.
Eigen::Vector3d turned(const Eigen::Vector3d& w_rad_per_s, double duration_s, std::int64_t steps,
                       Integrator integrator) {
  RigidBodySolver solver(setup_of({top(w_rad_per_s)}, duration_s / static_cast<double>(steps), integrator));
  const Kinematics end = advance(solver, steps);
  return about_principal_axes(end.orientation_wxyz.col(0), end.angular_velocity_rad_per_s.col(0));
}

// With |L|² > 2 E I₂ the body turns around its third axis, [Landau & Lifshitz, Mechanics, (37.8) to (37.12)]
//   ω₁ ∝ cn τ,  ω₂ ∝ sn τ,  ω₃ ∝ dn τ,   τ = t √((I₃ − I₂)(L² − 2 E I₁)/(I₁ I₂ I₃)),
//   k² = (I₂ − I₁)(2 E I₃ − L²)/((I₃ − I₂)(L² − 2 E I₁)):
// after a time of 2 K(k) the first two change their sign, and the body has flipped.
TEST(AsymmetricTop, FlipsWithThePeriodOfJacobisEllipticFunctionsAtTheOrderOfTheIntegrator) {
  const Eigen::Vector3d start(0.99, 0.0, 0.8 * std::numbers::sqrt2);  // beside the separatrix
  const Eigen::Vector3d& I = moments_kg_m2;
  const double L2 = I.cwiseProduct(start).squaredNorm();
  const double twice_E = I.dot(start.cwiseAbs2());
  const double rate_per_s = std::sqrt((I[2] - I[1]) * (L2 - twice_E * I[0]) / I.prod());
  const double k2 = (I[1] - I[0]) * (twice_E * I[2] - L2) / ((I[2] - I[1]) * (L2 - twice_E * I[0]));
  ASSERT_GT(k2, 0.5);
  ASSERT_LT(k2, 1.0);
  const double flip_s = 2.0 * std::comp_ellint_1(std::sqrt(k2)) / rate_per_s;
  for (const auto& [integrator, steps, order] :
       {std::tuple(Integrator::runge_kutta_4, 400, 4.0), std::tuple(Integrator::semi_implicit_euler, 50000, 1.0)}) {
    std::array<double, 2> error{};
    for (const int finer : {0, 1}) {
      const Eigen::Vector3d end = turned(start, flip_s, steps << finer, integrator);
      error[finer] = (end - Eigen::Vector3d(-start[0], 0.0, start[2])).norm();
    }
    EXPECT_LT(error[0], 1e-3);
    EXPECT_NEAR(std::log2(error[0] / error[1]), order, 0.25);
  }
}

/// Relative change of energy and angular momentum, with 2π/|ω| taken for a turn.
std::array<double, 2> drift(int turns, int steps_per_turn) {
  const Eigen::Vector3d start(0.3, 1.0, 0.2);
  const Eigen::Vector3d end = turned(start, turns * 2.0 * std::numbers::pi / start.norm(),
                                     static_cast<std::int64_t>(turns) * steps_per_turn, Integrator::runge_kutta_4);
  const auto energy = [](const Eigen::Vector3d& w) { return moments_kg_m2.dot(w.cwiseAbs2()); };
  const auto momentum = [](const Eigen::Vector3d& w) { return moments_kg_m2.cwiseProduct(w).norm(); };
  return {energy(end) / energy(start) - 1.0, momentum(end) / momentum(start) - 1.0};
}

TEST(AsymmetricTop, KeepsEnergyToTheOrderOfRungeKutta4AndAngularMomentumToRounding) {
  const auto [coarse, rounding] = drift(1000, 64);
  const auto [fine, rounding_of_fine] = drift(1000, 128);
  EXPECT_NEAR(std::log2(coarse / fine), 5.0, 0.3);
  const auto [long_run, rounding_of_long_run] = drift(100'000, 64);
  EXPECT_NEAR(long_run / coarse, 100.0, 15.0);  // proportional to time
  EXPECT_LT(std::abs(long_run), 3e-3);
  for (const double change : {rounding, rounding_of_fine, rounding_of_long_run}) EXPECT_LT(std::abs(change), 1e-13);
}

}  // namespace
}  // namespace copepod::body
