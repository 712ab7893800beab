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

// Streaming moves, bounce-back returns and collision redistributes populations: mass can change by
// rounding only.
TEST(ClosedBox, ConservesMassToRounding) {
  FluidSetup setup = lattice_unit_setup({20, 18, 22}, 1.0 / 18.0, BoundaryKind::no_slip);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  FlowCase flow(setup, resting({Eigen::Vector3d(10.0, 9.0, 11.0)}));
  flow.run(1);  // maps the sphere
  flow.solver().initialise(swirl);
  const auto excess_mass = [&] {
    const FieldBlock fields = flow.solver().fields();
    double sum = 0.0;
    for (std::size_t i = 0; i < fields.body.size(); ++i)
      if (fields.body[i] == 0) sum += fields.density_kg_per_m3[i] - 1.0;
    return sum;
  };
  const double before = excess_mass();
  flow.run(2000);
  EXPECT_GT(std::abs(before), 0.1);
  EXPECT_NEAR(excess_mass(), before, 1e-11);
}

// The momentum that a resting sphere in a periodic box receives is what the fluid loses, step by step.
TEST(ClosedBox, SphereReceivesTheMomentumThatTheFluidLoses) {
  FluidSetup setup = lattice_unit_setup({20, 18, 22}, 1.0 / 18.0, BoundaryKind::periodic);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  FlowCase flow(setup, resting({Eigen::Vector3d(10.0, 9.0, 11.0)}));
  flow.run(1);
  flow.solver().initialise(swirl);
  const auto momentum = [&] {
    const FieldBlock fields = flow.solver().fields();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < fields.body.size(); ++i)
      if (fields.body[i] == 0)
        for (int axis = 0; axis < 3; ++axis)
          sum[axis] += fields.density_kg_per_m3[i] * fields.velocity_m_per_s[3 * i + static_cast<std::size_t>(axis)];
    return sum;
  };
  Eigen::Vector3d before = momentum();
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  for (int step = 0; step < 100; ++step) {
    flow.run(1);
    impulse += flow.loads().force_N.col(0);
  }
  EXPECT_GT(impulse.norm(), 1e-2);
  EXPECT_LT((momentum() + impulse - before).norm(), 1e-11);
}

}  // namespace
}  // namespace copepod::fluid::validation
