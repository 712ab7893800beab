#include <cmath>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

LocalFlow swirl(const Cell& cell) {
  const Eigen::Vector3d u(std::sin(0.5 * static_cast<double>(cell[1])), std::cos(0.3 * static_cast<double>(cell[2])),
                          std::sin(0.4 * static_cast<double>(cell[0])));
  return {1e-3 * std::cos(0.2 * static_cast<double>(cell[0] + cell[1])), 0.02 * u};
}

/// Mass by which the fluid cells exceed fluid at rest.
double excess_mass(const FlowCase<>& flow) {
  const FieldBlock fields = flow.solver().fields();
  double sum = 0.0;
  for (std::size_t i = 0; i < fields.body.size(); ++i)
    if (fields.body[i] == 0) sum += fields.density_kg_per_m3[i] - 1.0;
  return sum;
}

// Streaming moves, bounce-back returns and collision redistributes populations: mass can change by
// rounding only.
TEST(ClosedBox, ConservesMassToRounding) {
  FluidSetup setup = lattice_unit_setup({20, 18, 22}, 1.0 / 18.0, BoundaryKind::no_slip);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  FlowCase flow(setup, resting({Eigen::Vector3d(10.0, 9.0, 11.0)}));
  flow.run(1);  // maps the sphere
  flow.solver().initialise(swirl);
  const double before = excess_mass(flow);
  flow.run(2000);
  EXPECT_GT(std::abs(before), 0.1);
  EXPECT_NEAR(excess_mass(flow), before, 1e-11);
}

/// What 2000 steps of a sphere that is pushed to and fro across some 8 cells add to the mass of its box.
double mass_gained(MovingBoundary moving_boundary, Refill refill) {
  FluidSetup setup = lattice_unit_setup({20, 18, 32}, 1.0 / 18.0, BoundaryKind::no_slip);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  setup.moving_boundary = moving_boundary;
  setup.refill = refill;
  FlowCase flow(setup, resting({Eigen::Vector3d(10.0, 9.0, 16.0)}));
  for (int step = 0; step < 2000; ++step) {
    const double phase = 0.005 * step;
    flow.kinematics().position_m.col(0) << 10.0, 9.0 + std::sin(phase), 16.0 + 4.0 * std::sin(phase);
    flow.kinematics().velocity_m_per_s.col(0) << 0.0, 0.005 * std::cos(phase), 0.02 * std::cos(phase);
    flow.run(1);
  }
  return excess_mass(flow);
}

// With bounce-back, covered and uncovered cells and the links of a moving surface make and lose mass. Formulas
// that conserve it give back what a surface absorbs: only what it absorbed in the last steps is missing.
TEST(ClosedBox, KeepsItsMassAroundAMovingSphereWithConservingFormulas) {
  EXPECT_GT(std::abs(mass_gained(MovingBoundary::bounce_back, Refill::equilibrium)), 0.3);
  EXPECT_LT(std::abs(mass_gained(MovingBoundary::parabolic, Refill::nonequilibrium)), 0.02);
  EXPECT_LT(std::abs(mass_gained(MovingBoundary::interpolated, Refill::grad)), 0.02);
}

Eigen::Vector3d momentum(const FlowCase<>& flow) {
  const FieldBlock fields = flow.solver().fields();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < fields.body.size(); ++i)
    if (fields.body[i] == 0)
      for (int axis = 0; axis < 3; ++axis)
        sum[axis] += fields.density_kg_per_m3[i] * fields.velocity_m_per_s[3 * i + static_cast<std::size_t>(axis)];
  return sum;
}

/// Momentum that fluid and bodies gain together, by the sum of the impulses of the bodies.
struct Drift {
  double found;     ///< from the fields and the loads
  double reported;  ///< by the solver
};

/// Of 500 steps of two spheres that move to and fro across some 5 cells of a periodic box and almost touch.
Drift drift_of(MovingBoundary moving_boundary, Refill refill, double film_cells) {
  FluidSetup setup = lattice_unit_setup({20, 18, 32}, 1.0 / 18.0, BoundaryKind::periodic);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}, {ShapeKind::sphere, 4.0, 0.0}};
  setup.moving_boundary = moving_boundary;
  setup.refill = refill;
  setup.film_thickness_m = film_cells;
  FlowCase flow(setup, resting({Eigen::Vector3d(10.0, 9.0, 10.0), Eigen::Vector3d(10.3, 9.0, 19.0)}));
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  double all_impulses = 0.0;
  for (int step = 0; step < 500; ++step) {
    const double phase = 0.01 * step;
    flow.kinematics().position_m.col(0) << 10.0, 9.0 + std::sin(phase), 10.0 + 2.5 * std::sin(phase);
    flow.kinematics().velocity_m_per_s.col(0) << 0.0, 0.01 * std::cos(phase), 0.025 * std::cos(phase);
    flow.kinematics().position_m.col(1) << 10.3, 9.0, 19.0 + 1.6 * std::sin(phase);
    flow.kinematics().velocity_m_per_s.col(1) << 0.0, 0.0, 0.016 * std::cos(phase);
    flow.run(1);
    impulse += flow.loads().force_N.rowwise().sum();
    all_impulses += flow.loads().force_N.col(0).norm() + flow.loads().force_N.col(1).norm();
  }
  return {(momentum(flow) + impulse).norm() / all_impulses, flow.solver().summarise().momentum_drift.value()};
}

// No walls, no forces: what the fluid does not pass on to the bodies is what it gains by numerics, to rounding.
TEST(ClosedBox, ReportsTheMomentumThatFluidAndMovingBodiesGainTogether) {
  const Drift drifts[] = {drift_of(MovingBoundary::bounce_back, Refill::equilibrium, 0.0),
                          drift_of(MovingBoundary::parabolic, Refill::nonequilibrium, 0.0),
                          drift_of(MovingBoundary::parabolic, Refill::nonequilibrium, 2.0),
                          drift_of(MovingBoundary::bounce_back, Refill::grad, 2.0)};
  for (const Drift& drift : drifts) {
    EXPECT_GT(drift.found, 1e-4);
    EXPECT_NEAR(drift.reported, drift.found, 1e-10);
  }
}

// The momentum that a resting sphere in a periodic box receives is what the fluid loses, step by step.
TEST(ClosedBox, SphereReceivesTheMomentumThatTheFluidLoses) {
  FluidSetup setup = lattice_unit_setup({20, 18, 22}, 1.0 / 18.0, BoundaryKind::periodic);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  FlowCase flow(setup, resting({Eigen::Vector3d(10.0, 9.0, 11.0)}));
  flow.run(1);
  flow.solver().initialise(swirl);
  const Eigen::Vector3d before = momentum(flow);
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  for (int step = 0; step < 100; ++step) {
    flow.run(1);
    impulse += flow.loads().force_N.col(0);
  }
  EXPECT_GT(impulse.norm(), 1e-2);
  EXPECT_LT((momentum(flow) + impulse - before).norm(), 1e-11);
}

}  // namespace
}  // namespace copepod::fluid::validation
