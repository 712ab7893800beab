#include "lattice_boltzmann/lattice/initial_flow.hpp"

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

FluidSetup setup_of(InitialFlowKind kind) {
  FluidSetup setup;
  setup.step_s = 0.5;
  setup.cell_size_m = 0.1;
  setup.density_kg_per_m3 = 1000.0;
  setup.domain_cells = {40, 20, 10};
  if (kind == InitialFlowKind::taylor_green_3d) setup.domain_cells = {40, 40, 40};
  setup.initial_flow = {kind, {0.01, 0.02, 0.03}, 0.004};
  setup.boundaries[3] = {BoundaryKind::velocity, {0.002, 0.0, 0.001}, 0.0};
  setup.boundaries[2] = {BoundaryKind::velocity, {-0.002, 0.0, 0.0}, 0.0};
  return setup;
}

LocalFlow flow_in(InitialFlowKind kind, const Cell& cell) {
  const FluidSetup setup = setup_of(kind);
  return initial_flow(setup, LatticeUnits(setup), cell);
}

TEST(InitialFlow, IsInLatticeUnits) {
  EXPECT_TRUE(flow_in(InitialFlowKind::uniform, {3, 4, 5}).velocity.isApprox(Eigen::Vector3d(0.05, 0.1, 0.15)));
  EXPECT_TRUE(flow_in(InitialFlowKind::rest, {3, 4, 5}).velocity.isZero(0.0));
  // Between −0.01 and 0.01 at the faces, which are half a cell from the outermost centres.
  EXPECT_NEAR(flow_in(InitialFlowKind::shear, {7, 0, 5}).velocity.x(), -0.01 + 0.5 * 0.02 / 20.0, 1e-16);
  EXPECT_NEAR(flow_in(InitialFlowKind::shear, {7, 19, 5}).velocity.z(), 19.5 * 0.005 / 20.0, 1e-16);
}

TEST(InitialFlow, HasTheGradientOfItsVelocityAndNoDivergence) {
  for (const auto kind : {InitialFlowKind::shear, InitialFlowKind::taylor_green, InitialFlowKind::taylor_green_3d}) {
    const Cell cell{11, 7, 4};
    const LocalFlow flow = flow_in(kind, cell);
    EXPECT_NEAR(flow.gradient.trace(), 0.0, 1e-18);
    EXPECT_GT(flow.gradient.norm(), 1e-4);
    for (int axis = 0; axis < 3; ++axis) {
      Cell before = cell, after = cell;
      --before[static_cast<std::size_t>(axis)];
      ++after[static_cast<std::size_t>(axis)];
      const Eigen::Vector3d difference = 0.5 * (flow_in(kind, after).velocity - flow_in(kind, before).velocity);
      EXPECT_NEAR((difference - flow.gradient.col(axis)).norm(), 0.0, 0.02 * flow.gradient.norm()) << axis;
    }
  }
}

// ρ Du/Dt = −∇p + ν ∇²u with steady streamlines: ∇p = −ρ (u·∇) u.
TEST(InitialFlow, OfAVortexHasThePressureOfItsCurvedStreamlines) {
  const Cell cell{11, 7, 4};
  const LocalFlow flow = flow_in(InitialFlowKind::taylor_green, cell);
  const Eigen::Vector3d acceleration = flow.gradient * flow.velocity;
  for (int axis = 0; axis < 2; ++axis) {
    Cell before = cell, after = cell;
    --before[static_cast<std::size_t>(axis)];
    ++after[static_cast<std::size_t>(axis)];
    const double rise = flow_in(InitialFlowKind::taylor_green, after).excess_density -
                        flow_in(InitialFlowKind::taylor_green, before).excess_density;
    EXPECT_NEAR(0.5 * rise / 3.0, -acceleration[axis], 0.08 * acceleration.norm()) << axis;
  }
}

// ∇²p = −ρ tr (∇u)², which without a divergence is all that p must fulfil.
TEST(InitialFlow, OfAVortexInThreeDimensionsHasThePressureOfItsStrainAndRotation) {
  const auto flow_at = [](const Cell& cell) { return flow_in(InitialFlowKind::taylor_green_3d, cell); };
  for (const Cell& cell : {Cell{11, 7, 4}, Cell{3, 18, 33}}) {
    double laplacian = -6.0 * flow_at(cell).excess_density;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int way : {-1, 1}) {
        Cell beside = cell;
        beside[axis] += way;
        laplacian += flow_at(beside).excess_density;
      }
    const Eigen::Matrix3d gradient = flow_at(cell).gradient;
    EXPECT_NEAR(laplacian / 3.0, -(gradient * gradient).trace(), 0.02 * gradient.squaredNorm());
  }
}

TEST(StartingDeviation, CarriesDensityMomentumViscousStressAndHalfOfTheForce) {
  LocalFlow flow{0.01, {0.02, -0.01, 0.03}};
  flow.gradient << 0.001, 0.004, 0, -0.002, 0.003, 0, 0, 0.005, -0.004;
  flow.force = {0.002, 0.006, -0.004};
  const double tau = 0.8;
  double excess = 0.0;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  Eigen::Matrix3d stress = Eigen::Matrix3d::Zero();  // less that of the equilibrium
  const double velocity[3] = {flow.velocity[0], flow.velocity[1], flow.velocity[2]};
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
    const Eigen::Vector3d e(d3q19::e[alpha][0], d3q19::e[alpha][1], d3q19::e[alpha][2]);
    const double f = starting_deviation(alpha, flow, tau);
    excess += f;
    momentum += f * e;
    stress += (f - equilibrium_deviation(alpha, flow.excess_density, velocity)) * e * e.transpose();
  }
  EXPECT_NEAR(excess, 0.01, 1e-16);
  EXPECT_NEAR((momentum - 1.01 * flow.velocity - 0.5 * flow.force).norm(), 0.0, 1e-16);
  // Π^neq before the collision is −(2τ/3) ρ S; the collision leaves 1 − 1/τ of it.
  const Eigen::Matrix3d strain = 0.5 * (flow.gradient + flow.gradient.transpose());
  const Eigen::Matrix3d expected = -(1.0 - 1.0 / tau) * (2.0 * tau / 3.0) * 1.01 * strain;
  EXPECT_NEAR((stress - expected).norm(), 0.0, 1e-16);
}

}  // namespace
}  // namespace copepod::fluid
