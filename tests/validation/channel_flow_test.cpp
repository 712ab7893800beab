#include <cmath>
#include <complex>
#include <numbers>

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

// Stokes' second problem between walls: u = Im(U sinh k(H − x) / sinh(kH) e^{iωt}), k² = iω/ν. The wave decays
// within 4.5 cells: 0.1 % are left of a discretisation of second order; half a step too early or late would be 0.5 %.
TEST(ChannelFlow, WallThatOscillatesSendsOutStokesWaves) {
  FluidSetup setup = channel(0.1);
  const double speed = 1e-3;
  constexpr int period = 640;
  setup.boundaries[0] = {.kind = BoundaryKind::velocity, .velocity_m_per_s = {0.0, speed, 0.0}};
  setup.boundaries[0].signal = {.kind = SignalKind::sinusoid, .amplitude = 1.0, .period_steps = period, .table = {}};
  FlowCase flow(setup);
  flow.run(8 * period);
  const std::complex<double> i(0.0, 1.0);
  const double omega = 2.0 * std::numbers::pi / period;
  const std::complex<double> k = std::sqrt(i * omega / 0.1);
  for (int eighth = 1; eighth <= 8; ++eighth) {
    flow.run(period / 8);
    const auto wave = [&](double x) {
      return speed * std::imag(std::sinh(k * (width - x)) / std::sinh(k * static_cast<double>(width)) *
                               std::exp(i * (omega * eighth * period / 8.0)));
    };
    EXPECT_LT(profile_error(flow.solver().fields(), 1, wave), 0.002) << eighth;
  }
}

// Between walls that move, shear is steady; what changes is of the order of the velocity squared.
TEST(ChannelFlow, CouetteProfileStaysAsItStarts) {
  for (const double viscosity : {1.0 / 30.0, 1.0 / 6.0, 0.5}) {
    for (const auto collision : {CollisionKind::bgk, CollisionKind::trt, CollisionKind::central_moments}) {
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

/// The steady flow in a slit that a pressure gradient drives along y, between open faces, or a body force all along it.
template <class T>
FieldBlock slit(CollisionKind collision, double viscosity, double gradient, bool has_open_faces) {
  constexpr int length = 12;
  FluidSetup setup = lattice_unit_setup({width, length, 4}, viscosity, BoundaryKind::periodic);
  setup.collision = collision;
  set_axis(setup, 0, BoundaryKind::no_slip);
  if (has_open_faces) {
    setup.boundaries[2] = {BoundaryKind::pressure, Eigen::Vector3d::Zero(), 0.5 * length * gradient};
    setup.boundaries[3] = {BoundaryKind::pressure, Eigen::Vector3d::Zero(), -0.5 * length * gradient};
  } else {
    setup.body_force_N_per_m3 = {0.0, gradient, 0.0};
  }
  FlowCase<T> flow(setup);
  flow.run(static_cast<int>(400.0 / viscosity));
  return flow.solver().fields();
}

/// By how much their velocities differ, relative to those of the second.
double largest_difference(const FieldBlock& one, const FieldBlock& other) {
  double worst = 0.0;
  for (std::size_t i = 1; i < one.velocity_m_per_s.size(); i += 3)
    worst = std::max(worst, std::abs(one.velocity_m_per_s[i] / other.velocity_m_per_s[i] - 1.0));
  return worst;
}

// Up to the open faces, and in cells beside the walls, whatever the collision, and also where it shifts bounce-back
// walls. What differs is the density, by 3 · 6 cells · gradient; in single precision also rounding.
TEST(ChannelFlow, PressureDifferenceDrivesTheFlowOfABodyForceUpToTheOpenFaces) {
  for (const auto collision : {CollisionKind::trt, CollisionKind::bgk, CollisionKind::central_moments})
    for (const double viscosity : {1.0 / 30.0, 1.0 / 6.0, 0.8}) {
      const auto difference = [&]<class T>(T /*precision*/, double gradient) {
        return largest_difference(slit<T>(collision, viscosity, gradient, true),
                                  slit<T>(collision, viscosity, gradient, false));
      };
      EXPECT_LT(difference(0.0, 1e-6), 3e-5) << "viscosity " << viscosity;
      EXPECT_LT(difference(0.0F, 1e-5), 5e-4) << "viscosity " << viscosity;
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
