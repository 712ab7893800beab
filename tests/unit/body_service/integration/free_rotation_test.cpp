// Torque-free rotation of a capsule: what is conserved, and the closed form of the symmetric top.

#include <cmath>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "geometry/rotation.hpp"
#include "model/body_model.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

BodySpecification spinning_capsule() {
  BodySpecification body = capsule("top", {0, 0, 0});
  body.orientation_wxyz = Eigen::Vector4d(0.8, 0.3, -0.4, 0.2).normalized();
  body.angular_velocity_rad_per_s = {2.0, -1.0, 3.0};
  return body;
}

Eigen::Matrix3d inertia_W(const BodySpecification& body, const Eigen::Vector4d& q_WB) {
  const Eigen::Matrix3d R_WB = rotation_matrix(q_WB);
  return R_WB * inertia_tensor_kg_m2(body.shape, body.mass_kg) * R_WB.transpose();
}

class FreeRotation : public testing::TestWithParam<Integrator> {};

TEST_P(FreeRotation, ConservesAngularMomentumAndUnitLength) {
  const BodySpecification body = spinning_capsule();
  RigidBodySolver solver(setup_of({body}, 1e-3, GetParam()));
  const Eigen::Vector3d L = inertia_W(body, body.orientation_wxyz) * body.angular_velocity_rad_per_s;
  const Kinematics end = advance(solver, 20000);
  const Eigen::Vector4d q = end.orientation_wxyz.col(0);
  EXPECT_NEAR(q.norm(), 1.0, 2e-15);
  EXPECT_TRUE((inertia_W(body, q) * end.angular_velocity_rad_per_s.col(0)).isApprox(L, 1e-13));
  EXPECT_TRUE(end.position_m.isZero(0.0));
}

INSTANTIATE_TEST_SUITE_P(Of, FreeRotation, testing::Values(Integrator::semi_implicit_euler, Integrator::runge_kutta_4),
                         [](const auto& integrator) {
                           return integrator.param == Integrator::runge_kutta_4 ? "RungeKutta4" : "SemiImplicitEuler";
                         });

TEST(FreeRotationWithRungeKutta4, ConservesEnergy) {
  const BodySpecification body = spinning_capsule();
  RigidBodySolver solver(setup_of({body}, 1e-3));
  const auto energy = [&](const Eigen::Vector4d& q, const Eigen::Vector3d& w) {
    return 0.5 * w.dot(inertia_W(body, q) * w);
  };
  const double start = energy(body.orientation_wxyz, body.angular_velocity_rad_per_s);
  const Kinematics end = advance(solver, 20000);
  EXPECT_NEAR(energy(end.orientation_wxyz.col(0), end.angular_velocity_rad_per_s.col(0)) / start, 1.0, 1e-12);
}

TEST(FreeRotationWithRungeKutta4, PrecessesAsASymmetricTop) {
  // The axis of a symmetric top turns about the fixed direction of L at the rate |L| / I_transverse.
  const BodySpecification body = spinning_capsule();
  constexpr double step_s = 1e-3;
  constexpr int steps = 5000;
  RigidBodySolver solver(setup_of({body}, step_s));
  const Eigen::Vector3d L = inertia_W(body, body.orientation_wxyz) * body.angular_velocity_rad_per_s;
  const double transverse = inertia_tensor_kg_m2(body.shape, body.mass_kg)(0, 0);
  const Eigen::Vector4d turned = rotated(L / transverse * (step_s * steps), body.orientation_wxyz);
  const Kinematics end = advance(solver, steps);
  EXPECT_TRUE(z_axis(end.orientation_wxyz.col(0)).isApprox(z_axis(turned), 1e-10));
  EXPECT_GT((z_axis(turned) - z_axis(body.orientation_wxyz)).norm(), 0.1) << "nothing would be tested";
}

}  // namespace
}  // namespace copepod::body
