#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

/// Loads on two spheres of radius 4 with the given distance between their surfaces, at rest in a fluid
/// at rest.
double largest_load(double gap) {
  FluidSetup setup = lattice_unit_setup({24, 24, 40}, 1.0 / 18.0, BoundaryKind::no_slip);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}, {ShapeKind::sphere, 4.0, 0.0}};
  const double half = 4.0 + 0.5 * gap;
  FlowCase flow(setup, resting({Eigen::Vector3d(12.3, 11.6, 20.2 - half), Eigen::Vector3d(12.3, 11.6, 20.2 + half)}));
  double largest = 0.0;
  for (int step = 0; step < 50; ++step) {
    flow.run(1);
    largest =
        std::max({largest, flow.loads().force_N.cwiseAbs().maxCoeff(), flow.loads().torque_N_m.cwiseAbs().maxCoeff()});
  }
  return largest;
}

// The pressure of the fluid at rest is the same on all sides of a body, also where links between close bodies
// are missing.
TEST(RestingBodies, FeelExactlyNothingOneCellApart) { EXPECT_EQ(largest_load(1.0), 0.0); }
TEST(RestingBodies, FeelExactlyNothingWhenTheyTouch) { EXPECT_EQ(largest_load(0.0), 0.0); }

// The same bodies do feel a fluid that moves: the zeros above are not those of a solver that reports nothing.
TEST(RestingBodies, FeelAMovingFluid) {
  FluidSetup setup = lattice_unit_setup({24, 24, 40}, 1.0 / 18.0, BoundaryKind::no_slip);
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  setup.initial_flow = {InitialFlowKind::uniform, {0.0, 0.0, 1e-3}};
  FlowCase flow(setup, resting({Eigen::Vector3d(12.3, 11.6, 20.2)}));
  flow.run(1);
  EXPECT_GT(flow.loads().force_N(2, 0), 0.0);
}

}  // namespace
}  // namespace copepod::fluid::validation
