#include "stokes/stokes_flow.hpp"

#include <numbers>

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::fluid {
namespace {

using std::numbers::pi;

SolverContext context;
const SelfCommunicator alone{context};

FluidSetup unit_fluid(std::vector<double> radii) {
  FluidSetup setup;
  setup.kind = FluidKind::stokes;
  setup.density_kg_per_m3 = 2.0;
  setup.kinematic_viscosity_m2_per_s = 0.5;  // η = 1
  for (const double radius : radii) setup.bodies.push_back({ShapeKind::sphere, radius, 0.0});
  return setup;
}

Kinematics at(const std::vector<Eigen::Vector3d>& positions) {
  Kinematics kinematics;
  kinematics.resize(static_cast<Eigen::Index>(positions.size()));
  for (std::size_t b = 0; b < positions.size(); ++b)
    kinematics.position_m.col(static_cast<Eigen::Index>(b)) = positions[b];
  kinematics.velocity_m_per_s.setZero();
  kinematics.angular_velocity_rad_per_s.setZero();
  return kinematics;
}

TEST(StokesFlow, GivesStokesDragAndKirchhoffTorqueOnASingleSphere) {
  StokesFlow flow(unit_fluid({0.7}), alone);
  Kinematics kinematics = at({{1.0, 2.0, 3.0}});
  kinematics.velocity_m_per_s.col(0) << 0.1, 0.2, -0.3;
  kinematics.angular_velocity_rad_per_s.col(0) << 1.0, 0.0, 2.0;
  Loads loads;
  flow.exchange(kinematics, loads);
  EXPECT_TRUE(loads.force_N.col(0).isApprox(-6.0 * pi * 0.7 * kinematics.velocity_m_per_s.col(0), 1e-14));
  EXPECT_TRUE(
      loads.torque_N_m.col(0).isApprox(-8.0 * pi * 0.343 * kinematics.angular_velocity_rad_per_s.col(0), 1e-14));
}

// Two equal spheres that approach each other: friction 6πηa / (1 − 3a/(2r) + (a/r)³) in the
// Rotne-Prager approximation.
TEST(StokesFlow, ApproachingSpheresFeelTheRotnePragerFriction) {
  StokesFlow flow(unit_fluid({1.0, 1.0}), alone);
  const double r = 5.0;
  Kinematics kinematics = at({{0.0, 0.0, 0.0}, {0.0, 0.0, r}});
  kinematics.velocity_m_per_s(2, 0) = 1.0;
  kinematics.velocity_m_per_s(2, 1) = -1.0;
  Loads loads;
  flow.exchange(kinematics, loads);
  const double expected = -6.0 * pi / (1.0 - 1.5 / r + 1.0 / (r * r * r));
  EXPECT_NEAR(loads.force_N(2, 0), expected, 1e-12);
  EXPECT_NEAR(loads.force_N(2, 1), -expected, 1e-12);
}

// Lorentz reciprocity makes the mobility symmetric; dissipation makes it positive.
TEST(GrandMobility, IsSymmetricAndPositiveForUnequalSpheresCloseToContact) {
  Eigen::Matrix3Xd positions(3, 3);
  positions << 0.0, 2.3, 0.4, 0.0, 0.5, 2.9, 0.0, -0.3, 1.1;
  const std::vector<double> radii = {1.0, 1.3, 0.9};
  const Eigen::MatrixXd mobility = grand_mobility(positions, radii, 1.0);
  EXPECT_LT((mobility - mobility.transpose()).norm(), 1e-16);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(mobility).eigenvalues().minCoeff(), 0.0);
}

// A torque on one sphere drags the other along: u = T × r / (8πηr³), the rotlet.
TEST(GrandMobility, CouplesATorqueToTheFlowOfARotlet) {
  Eigen::Matrix3Xd positions(3, 2);
  positions << 0.0, 3.0, 0.0, 0.0, 0.0, 0.0;
  const std::vector<double> radii = {1.0, 1.0};
  Eigen::VectorXd load = Eigen::VectorXd::Zero(12);
  load[6 + 2] = 1.0;  // torque about z on sphere 0
  const Eigen::VectorXd motion = grand_mobility(positions, radii, 1.0) * load;
  EXPECT_NEAR(motion[3 + 1], 1.0 / (8.0 * pi * 9.0), 1e-16);  // sphere 1 moves along +y
}

TEST(GrandMobility, NamesOverlappingSpheres) {
  Eigen::Matrix3Xd positions = Eigen::Matrix3Xd::Zero(3, 2);
  positions(2, 1) = 1.5;
  const std::vector<double> radii = {1.0, 1.0};
  EXPECT_THROW(grand_mobility(positions, radii, 1.0), SolverError);
}

TEST(StokesFlow, FeelsThePlaneOfItsSetup) {
  FluidSetup setup = unit_fluid({1.0});
  setup.no_slip_plane = 4;  // z = 0
  StokesFlow flow(setup, alone);
  Kinematics kinematics = at({{0.0, 0.0, 4.0}});
  kinematics.velocity_m_per_s.col(0) << 0.0, 0.0, 1.0;
  Loads loads;
  flow.exchange(kinematics, loads);
  const double s = 0.25;
  const double mobility = 1.0 - 9.0 / 8.0 * s + std::pow(s, 3) / 2.0 - std::pow(s, 5) / 8.0;
  EXPECT_NEAR(loads.force_N(2, 0), -6.0 * pi / mobility, 1e-12);
}

TEST(StokesFlow, RefusesCapsules) {
  FluidSetup setup = unit_fluid({1.0});
  setup.bodies.push_back({ShapeKind::capsule, 1.0, 2.0});
  EXPECT_THROW(StokesFlow(setup, alone), CaseError);
}

}  // namespace
}  // namespace copepod::fluid
