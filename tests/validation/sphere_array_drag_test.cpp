#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

/// Drag of a simple cubic array over Stokes drag at the superficial velocity, K(φ); dilute series of
/// [Sangani & Acrivos 1982]: 1/K = 1 − 1.7601 φ^{1/3} + φ − 1.5593 φ²; K(0.027) = 2.008 [Zick & Homsy 1982].
double reference_drag(double solid_fraction) {
  return 1.0 / (1.0 - 1.7601 * std::cbrt(solid_fraction) + solid_fraction - 1.5593 * solid_fraction * solid_fraction);
}

TEST(SphereArrayDrag, ReferenceSeriesAgreesWithZickAndHomsy) { EXPECT_NEAR(reference_drag(0.027), 2.008, 0.002); }

// Diameter 16 cells in a cell of 43: φ = 0.02697. A staircase sphere at this resolution is off by 1-2 % [Ladd
// 1994]. In the steady state the drag carries the whole body force, so K follows from the flow rate; the
// momentum exchange must then give the same force.
TEST(SphereArrayDrag, IsRightWithinTwoPercentAtDiameterSixteen) {
  const int cells = 43;
  const double radius = 8.0;
  const double viscosity = 0.5;
  const double volume = std::pow(cells, 3.0);
  const double force_density = 1e-7;
  FluidSetup setup = lattice_unit_setup({cells, cells, cells}, viscosity, BoundaryKind::periodic);
  setup.body_force_N_per_m3 = {0.0, 0.0, force_density};
  setup.bodies = {{ShapeKind::sphere, radius, 0.0}};
  FlowCase flow(setup, resting({Eigen::Vector3d::Constant(0.5 * cells)}));
  flow.run(5000);

  const FieldBlock fields = flow.solver().fields();
  double flow_rate = 0.0;
  std::int64_t fluid_cells = 0;
  for (std::size_t i = 0; i < fields.body.size(); ++i) {
    if (fields.body[i] != 0) continue;
    flow_rate += fields.velocity_m_per_s[3 * i + 2];
    ++fluid_cells;
  }
  const double superficial_velocity = flow_rate / volume;
  const double stokes = 6.0 * std::numbers::pi * viscosity * radius * superficial_velocity;
  const double solid_fraction = 4.0 / 3.0 * std::numbers::pi * std::pow(radius, 3.0) / volume;
  EXPECT_NEAR(force_density * volume / stokes / reference_drag(solid_fraction), 1.0, 0.02);
  // The body force acts on the fluid only; what the fluid gains it must lose to the sphere.
  EXPECT_NEAR(flow.loads().force_N(2, 0) / (force_density * static_cast<double>(fluid_cells)), 1.0, 1e-3);
  EXPECT_LT(std::abs(flow.loads().force_N(0, 0)), 1e-12 * flow.loads().force_N(2, 0));
}

}  // namespace
}  // namespace copepod::fluid::validation
