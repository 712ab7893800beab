#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "contract/errors.hpp"
#include "forces/forces.hpp"
#include "rigid_body_solver.hpp"

namespace copepod::body {
namespace {

constexpr double stiffness_N_m = 3.0;

double angle(const Eigen::Matrix3Xd& position_m) {
  const Eigen::Vector3d a = position_m.col(0) - position_m.col(1);
  const Eigen::Vector3d c = position_m.col(2) - position_m.col(1);
  return std::atan2(a.cross(c).norm(), a.dot(c));
}

Eigen::Matrix3Xd forces(const Eigen::Matrix3Xd& position_m, double rest_angle_rad) {
  BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {0, 0, 0}), bead("c", {0, 0, 0})}, 1.0);
  setup.bends = {{0, 1, 2, stiffness_N_m, rest_angle_rad}};
  BlockState state;
  state.resize(3);
  state.position_m = position_m;
  BlockVectors force = BlockVectors::Zero(3, 3);
  BlockVectors torque = force;
  const BodyBlock block{0, 3, {}, {0}, {}};
  Bends(setup).add_loads({block, state, torque, CentreLines(), Eigen::VectorXd()}, force, torque);
  EXPECT_TRUE(torque.isZero(0.0));
  return force;
}

const Eigen::Matrix3Xd askew = (Eigen::Matrix3Xd(3, 3) << 1.0, 0.2, -0.4, 0.1, 0.0, 0.9, -0.2, 0.3, 0.5).finished();

TEST(Bends, AreTheNegativeGradientOfTheirEnergy) {
  for (const double rest : {0.4, 2.0, std::numbers::pi}) {
    const Eigen::Matrix3Xd force = forces(askew, rest);
    for (Eigen::Index i = 0; i < askew.size(); ++i) {
      const auto energy = [&](double shift) {
        Eigen::Matrix3Xd shifted = askew;
        shifted.data()[i] += shift;
        return 0.5 * stiffness_N_m * std::pow(angle(shifted) - rest, 2);
      };
      EXPECT_NEAR(force.data()[i], (energy(-1e-6) - energy(1e-6)) / 2e-6, 1e-8) << i;
    }
  }
}

TEST(Bends, HaveNoNetForceAndNoNetTorque) {
  const Eigen::Matrix3Xd force = forces(askew, 2.0);
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (int i = 0; i < 3; ++i) moment += askew.col(i).head<3>().cross(force.col(i).head<3>());
  EXPECT_GT(force.norm(), 0.1);
  EXPECT_LT(force.rowwise().sum().norm(), 1e-14);
  EXPECT_LT(moment.norm(), 1e-14);
}

TEST(Bends, StayLinearForNearlyStraightArms) {
  for (const double deflection : {1e-3, 1e-8, 1e-13}) {
    const Eigen::Matrix3Xd force =
        forces((Eigen::Matrix3Xd(3, 3) << -1, 0, 1, deflection, 0, deflection, 0, 0, 0).finished(), std::numbers::pi);
    EXPECT_NEAR(force(1, 0) / (-stiffness_N_m * 2.0 * deflection), 1.0, deflection + 1e-12);
  }
  EXPECT_TRUE(forces((Eigen::Matrix3Xd(3, 3) << -1, 0, 2, 0, 0, 0, 0, 0, 0).finished(), std::numbers::pi).isZero(0.0));
}

TEST(Bends, NameTheBodiesWhoseArmsGiveNoDirection) {
  const Eigen::Matrix3Xd straight = (Eigen::Matrix3Xd(3, 3) << -1, 0, 2, 0, 0, 0, 0, 0, 0).finished();
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { forces(straight, 2.0); }), "the bend at 'b' to 'a' and 'c'"));
  const Eigen::Matrix3Xd oblique = Eigen::Vector3d(0.1, 0.7, 0.3) * Eigen::RowVector3d(-1, 0, 2);
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { forces(oblique, 2.0); }), "parallel or of no length"));
  const Eigen::Matrix3Xd coinciding = (Eigen::Matrix3Xd(3, 3) << 0, 0, 2, 0, 0, 0, 0, 0, 0).finished();
  EXPECT_TRUE(contains(reason_of<SolverError>([&] { forces(coinciding, 2.0); }), "parallel or of no length"));
}

TEST(Bends, RefuseWhatIsNotABend) {
  const auto reason = [](const BendSpecification& bend) {
    BodySetup setup = setup_of({bead("a", {0, 0, 0}), bead("b", {1, 0, 0}), bead("c", {0, 2, 0})}, 1.0);
    setup.bends = {bend};
    return reason_of<CaseError>([&] { const Bends refused(setup); });
  };
  EXPECT_TRUE(contains(reason({0, 1, 3, 1.0}), "joins bodies 0, 1 and 3"));
  EXPECT_TRUE(contains(reason({0, 1, 0, 1.0}), "needs three of the 3"));
  EXPECT_TRUE(contains(reason({0, 1, 2, -1.0}), "negative stiffness"));
  EXPECT_TRUE(contains(reason({0, 1, 2, 1.0, -0.1}), "rest angle"));
  EXPECT_TRUE(contains(reason({0, 1, 2, 1.0, 3.2}), "rest angle"));
}

// Small bending vibration of three equal beads, arms of length l: ÿ = −6 κ/(m l²) y for the relative deflection.
TEST(Bends, LetThreeBeadsVibrateAtTheirFrequency) {
  const double arm_m = 20e-6, mass_kg = 5.44e-13, kappa_N_m = 1e-11, step_s = 1e-8;
  BodySetup setup =
      setup_of({bead("a", {-arm_m, 1e-9, 0}), bead("b", {0, -2e-9, 0}), bead("c", {arm_m, 1e-9, 0})}, step_s);
  setup.bends = {{0, 1, 2, kappa_N_m}};
  RigidBodySolver solver(setup);
  const double omega = std::sqrt(6.0 * kappa_N_m / (mass_kg * arm_m * arm_m));
  const auto quarter = std::lround(std::numbers::pi / (2.0 * omega) / step_s);
  for (int part = 1; part <= 8; ++part) {
    const Kinematics state = advance(solver, quarter);
    const double expected = 1e-9 * std::cos(omega * step_s * static_cast<double>(part * quarter));
    EXPECT_NEAR(state.position_m(1, 0), expected, 1e-13) << part;
    EXPECT_NEAR(state.position_m(1, 1), -2.0 * expected, 2e-13) << part;
  }
}

}  // namespace
}  // namespace copepod::body
