#include <numbers>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

// A sphere that turns slowly in a fluid at rest feels T = −8 π μ R³ Ω [Kirchhoff 1876]; walls at distance L
// add some (R/L)³ = 0.4 % here. Half of the domain is computed (mirror plane normal to the axis of rotation),
// so the doubling of cut bodies is tested with it. Bounce-back at radius 8 gives the hydrodynamic radius
// within 2 %, its cube within 5 %.
TEST(RotatingSphere, FeelsKirchhoffsTorque) {
  const int cells = 52;
  const double radius = 8.0;
  const double viscosity = 0.5;
  FluidSetup setup = lattice_unit_setup({cells, cells, cells}, viscosity, BoundaryKind::no_slip);
  setup.symmetry_planes = {false, false, true};
  setup.bodies = {{ShapeKind::sphere, radius, 0.0}};
  Kinematics kinematics = resting({Eigen::Vector3d::Constant(0.5 * cells)});
  const double speed = 1e-4;
  kinematics.angular_velocity_rad_per_s.col(0) << 0.0, 0.0, speed;
  FlowCase flow(setup, kinematics);
  flow.run(1500);
  const double expected = -8.0 * std::numbers::pi * viscosity * std::pow(radius, 3.0) * speed;
  EXPECT_NEAR(flow.loads().torque_N_m(2, 0) / expected, 1.0, 0.05);
  EXPECT_LT(flow.loads().force_N.norm(), 1e-9 * std::abs(expected));
}

}  // namespace
}  // namespace copepod::fluid::validation
