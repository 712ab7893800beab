#include <cmath>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

constexpr int width = 16;

/// Largest deviation of u_y(x) from a profile, relative to the profile's maximum.
template <class Profile>
double profile_error(const FieldBlock& fields, int component, const Profile& profile) {
  double worst = 0.0;
  double largest = 0.0;
  for (int x = 0; x < width; ++x) {
    const double u = fields.velocity_m_per_s[3 * field_index(fields, x, 1, 1) + static_cast<std::size_t>(component)];
    worst = std::max(worst, std::abs(u - profile(x + 0.5)));
    largest = std::max(largest, std::abs(profile(x + 0.5)));
  }
  return worst / largest;
}

FluidSetup channel(double viscosity) {
  FluidSetup setup = lattice_unit_setup({width, 4, 4}, viscosity, BoundaryKind::periodic);
  set_axis(setup, 0, BoundaryKind::no_slip);
  return setup;
}

// TRT with Λ = 3/16 puts half-way bounce-back walls exactly half-way for a parabola [Ginzburg & d'Humières
// 2003], whatever the viscosity: the only error left is rounding and the end of the transient, far below
// 1e-9.
TEST(ChannelFlow, PoiseuilleProfileIsExactWithTrt) {
  for (const double viscosity : {1.0 / 6.0, 0.5}) {
    FluidSetup setup = channel(viscosity);
    const double force = 1e-6;
    setup.body_force_N_per_m3 = {0.0, force, 0.0};
    FlowCase flow(setup);
    flow.run(12000);
    const auto parabola = [&](double x) { return force / (2.0 * viscosity) * x * (width - x); };
    EXPECT_LT(profile_error(flow.solver().fields(), 1, parabola), 1e-9) << "viscosity " << viscosity;
  }
}

// With BGK the wall's place depends on the viscosity: the same test must see the difference.
TEST(ChannelFlow, PoiseuilleProfileIsNotExactWithBgk) {
  FluidSetup setup = channel(0.5);
  const double force = 1e-6;
  setup.collision = CollisionKind::bgk;
  setup.body_force_N_per_m3 = {0.0, force, 0.0};
  FlowCase flow(setup);
  flow.run(12000);
  const auto parabola = [&](double x) { return force * x * (width - x); };
  EXPECT_GT(profile_error(flow.solver().fields(), 1, parabola), 1e-4);
}

// A linear profile is exact for half-way bounce-back; the sliding wall is a boundary condition of
// kind velocity.
TEST(ChannelFlow, CouetteProfileBetweenASlidingAndARestingWallIsLinear) {
  FluidSetup setup = channel(1.0 / 6.0);
  const double speed = 1e-3;
  setup.boundaries[1] = {BoundaryKind::velocity, Eigen::Vector3d(0.0, 0.0, speed), 0.0};
  FlowCase flow(setup);
  flow.run(12000);
  EXPECT_LT(profile_error(flow.solver().fields(), 2, [&](double x) { return speed * x / width; }), 1e-9);
}

// Between walls that move, shear is steady; what changes is of the order of the velocity squared.
TEST(ChannelFlow, CouetteProfileStaysAsItStarts) {
  for (const double viscosity : {1.0 / 30.0, 1.0 / 6.0, 0.5}) {
    for (const CollisionKind collision : {CollisionKind::bgk, CollisionKind::trt}) {
      FluidSetup setup = channel(viscosity);
      setup.collision = collision;
      const double speed = 1e-5;
      setup.boundaries[0] = {BoundaryKind::velocity, Eigen::Vector3d(0.0, -speed, 0.0), 0.0};
      setup.boundaries[1] = {BoundaryKind::velocity, Eigen::Vector3d(0.0, speed, 0.0), 0.0};
      setup.initial_flow.kind = InitialFlowKind::shear;
      FlowCase flow(setup);
      const auto line = [&](double x) { return speed * (2.0 * x / width - 1.0); };
      for (int i = 0; i < 20; ++i) {
        flow.run(1);
        EXPECT_LT(profile_error(flow.solver().fields(), 1, line), 1e-6) << "viscosity " << viscosity << ", step " << i;
      }
    }
  }
}

// A pressure gradient G drives the same parabola as a body force G; half-way between the ends the profile
// must follow the gradient that is there. Anti-bounce-back takes the face's velocity from the cell beside it,
// first order, which costs a few percent of the imposed difference at the ends.
TEST(ChannelFlow, PressureDifferenceDrivesThePoiseuilleProfile) {
  const int length = 40;
  FluidSetup setup = lattice_unit_setup({width, length, 4}, 1.0 / 6.0, BoundaryKind::periodic);
  set_axis(setup, 0, BoundaryKind::no_slip);
  const double difference = 1e-5;
  setup.boundaries[2] = {BoundaryKind::pressure, Eigen::Vector3d::Zero(), difference};
  setup.boundaries[3] = {BoundaryKind::pressure, Eigen::Vector3d::Zero(), 0.0};
  FlowCase flow(setup);
  flow.run(12000);
  const FieldBlock fields = flow.solver().fields();
  const auto pressure = [&](int y) { return fields.density_kg_per_m3[field_index(fields, width / 2, y, 1)] / 3.0; };
  const double gradient = (pressure(15) - pressure(25)) / 10.0;
  EXPECT_NEAR(gradient / (difference / length), 1.0, 0.05);
  for (int x = 0; x < width; ++x) {
    const double expected = gradient / (2.0 / 6.0) * (x + 0.5) * (width - x - 0.5);
    EXPECT_NEAR(fields.velocity_m_per_s[3 * field_index(fields, x, length / 2, 1) + 1] / expected, 1.0, 2e-3);
  }
}

// Free slip between two planes: a uniform flow along them never decays.
TEST(ChannelFlow, FreeSlipWallsDoNotSlowAUniformFlow) {
  FluidSetup setup = lattice_unit_setup({8, 8, 8}, 1.0 / 6.0, BoundaryKind::periodic);
  set_axis(setup, 0, BoundaryKind::free_slip);
  setup.initial_flow = {InitialFlowKind::uniform, {0.0, 0.01, 0.02}};
  FlowCase flow(setup);
  flow.run(500);
  const FieldBlock fields = flow.solver().fields();
  for (std::int64_t x = 0; x < 8; ++x) {
    EXPECT_NEAR(fields.velocity_m_per_s[3 * field_index(fields, x, 3, 4) + 1], 0.01, 1e-14);
    EXPECT_NEAR(fields.velocity_m_per_s[3 * field_index(fields, x, 3, 4) + 2], 0.02, 1e-14);
  }
}

}  // namespace
}  // namespace copepod::fluid::validation
