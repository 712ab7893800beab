#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

constexpr double c_s = 0.57735026918962576;

/// Largest |ρ − 1| of what came back, over that of a wave of sound that left a stream through the high face of z.
/// @param width  of the wave, exp(−z²/width²)
template <class T>
double reflected(BoundaryKind face, double viscosity, double width, double speed,
                 CollisionKind collision = CollisionKind::trt) {
  constexpr int length = 200;
  constexpr double amplitude = 1e-3;
  FluidSetup setup = lattice_unit_setup({4, 4, length}, viscosity, BoundaryKind::periodic);
  setup.collision = collision;
  setup.boundaries[4] = {BoundaryKind::velocity, {0, 0, speed}};
  setup.boundaries[5].kind = face;
  FlowCase<T> flow(setup);
  flow.solver().initialise([&](const Cell& cell) {
    const double z = (static_cast<double>(cell[2]) + 0.5 - 0.75 * length) / width;
    LocalFlow local;
    local.excess_density = amplitude * std::exp(-z * z);
    local.velocity = {0, 0, c_s * local.excess_density + speed};
    return local;
  });
  flow.run(static_cast<int>(0.5 * length / (c_s + speed)));
  double largest = 0.0;
  for (const double density : flow.solver().fields().density_kg_per_m3)
    largest = std::max(largest, std::abs(density - 1.0));
  return largest / amplitude;
}

// What comes back of a wide wave is due to the weak pull towards the density at rest: less than 1 % up to a tenth of
// the domain. A pressure face sends all of it back, apart from what the viscosity takes.
TEST(Outflow, SendsBackLessThanAHundredthOfAWaveOfSound) {
  for (const double speed : {0.0, 0.05}) {
    for (const double viscosity : {1.0 / 600.0, 1.0 / 30.0}) {
      for (const double width : {5.0, 10.0, 20.0}) {
        EXPECT_LT(reflected<double>(BoundaryKind::outflow, viscosity, width, speed), 0.01) << width;
        EXPECT_GT(reflected<double>(BoundaryKind::pressure, viscosity, width, speed), 0.6) << width;
      }
    }
  }
  EXPECT_LT(reflected<float>(BoundaryKind::outflow, 1.0 / 30.0, 10.0, 0.05), 0.01);
  EXPECT_LT(reflected<double>(BoundaryKind::outflow, 1.0 / 600.0, 10.0, 0.05, CollisionKind::central_moments), 0.01);
}

/// Largest deviation from a uniform stream, after a body that moved with it was removed at an end of the domain.
template <class T>
double left_behind(const Shape& shape, int axis, bool down, MovingBoundary surface, Refill refill) {
  constexpr double speed = 0.05, length = 24.0;
  Cell cells{16, 16, 16};
  cells[axis] = 24;
  FluidSetup setup = lattice_unit_setup(cells, 0.1, BoundaryKind::free_slip);
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  velocity[axis] = down ? -speed : speed;
  setup.boundaries[face_index(axis, down)] = {BoundaryKind::velocity, velocity};
  setup.boundaries[face_index(axis, !down)] = {.kind = BoundaryKind::outflow, .removes_bodies = true};
  setup.initial_flow = {InitialFlowKind::uniform, velocity};
  setup.moving_boundary = surface;
  setup.refill = refill;
  setup.bodies = {shape};
  Eigen::Vector3d at(8.3, 7.9, 8.1);
  at[axis] = down ? 9.3 : length - 9.3;
  FlowCase<T> flow(setup, resting({at}));
  for (int step = 0; step < 160; ++step) {
    flow.kinematics().velocity_m_per_s.col(0) = velocity;
    flow.run(1);
    if (step < 85) flow.kinematics().position_m.col(0) += velocity;
    if (step == 85) flow.kinematics().position_m(axis, 0) = down ? -30.0 : length + 30.0;
  }
  double largest = 0.0;
  const FieldBlock fields = flow.solver().fields();
  for (std::size_t i = 0; i < fields.density_kg_per_m3.size(); ++i) {
    const Eigen::Map<const Eigen::Vector3d> found(&fields.velocity_m_per_s[3 * i]);
    largest = std::max({largest, std::abs(fields.density_kg_per_m3[i] - 1.0), (found - velocity).norm()});
  }
  return largest;
}

TEST(Removal, OfABodyThatMovesWithAUniformStreamLeavesItAsItWas) {
  const Shape ball{ShapeKind::sphere, 4.0, 0.0}, ellipsoid{.kind = ShapeKind::ellipsoid, .extents_m = {4.0, 3.0, 2.0}};
  const Shape pair{
      .kind = ShapeKind::compound,
      .radius_m = 3.0,
      .parts = {{{ShapeKind::sphere, 2.0, 0.0}, {1.5, 0, 0}}, {{ShapeKind::sphere, 2.0, 0.0}, {-1.5, 0, 0}}}};
  for (const int axis : {0, 1, 2})
    for (const bool down : {false, true})
      EXPECT_LT(left_behind<double>(ball, axis, down, MovingBoundary::parabolic, Refill::nonequilibrium), 1e-14);
  for (const Shape& shape : {ball, ellipsoid, pair})
    for (const MovingBoundary surface : {MovingBoundary::bounce_back, MovingBoundary::central_linear})
      for (const Refill refill : {Refill::equilibrium, Refill::grad})
        EXPECT_LT(left_behind<double>(shape, 0, false, surface, refill), 1e-14);
  EXPECT_LT(left_behind<float>(ball, 2, false, MovingBoundary::parabolic, Refill::grad), 1e-6);
}

/// The steady flow in a slit, along an axis, up or down, between walls normal to the next axis; as it comes in.
template <class T>
FieldBlock slit(int axis, bool down) {
  constexpr int width = 12, length = 30;
  const int across = (axis + 1) % 3;
  Cell cells{4, 4, 4};
  cells[axis] = length;
  cells[across] = width;
  FluidSetup setup = lattice_unit_setup(cells, 1.0 / 18.0, BoundaryKind::periodic);
  set_axis(setup, across, BoundaryKind::no_slip);
  Boundary inflow{.kind = BoundaryKind::velocity, .parabolic = true};
  inflow.velocity_m_per_s[axis] = down ? -1e-3 : 1e-3;
  setup.boundaries[face_index(axis, down)] = inflow;
  setup.boundaries[face_index(axis, !down)].kind = BoundaryKind::outflow;
  FlowCase<T> flow(setup);
  flow.run(12000);
  return flow.solver().fields();
}

/// Velocity along the flow, `along` cells from the inflow and `across` from a wall.
double speed_at(const FieldBlock& fields, int axis, bool down, int along, int across) {
  Cell cell{1, 1, 1};
  cell[axis] = down ? 29 - along : along;
  cell[(axis + 1) % 3] = across;
  const std::size_t place = 3 * field_index(fields, cell[0], cell[1], cell[2]) + static_cast<std::size_t>(axis);
  return fields.velocity_m_per_s[place] * (down ? -1.0 : 1.0);
}

// The profile is that of the flow between walls, so that it stays the same from the inflow to the outflow, along every
// axis. Links of a third of the weight have their velocity half a cell from the cell's: of a parabola on n cells they
// let in less by 1/(2n²). The density falls on the way, by 3e-4 in all, and is the one at rest at the outflow.
TEST(Inflow, OfAParabolaIsTheFlowBetweenWallsUpToTheOutflow) {
  for (const int axis : {0, 1, 2}) {
    for (const bool down : {false, true}) {
      const FieldBlock fields = slit<double>(axis, down);
      for (const int along : {0, 14, 29}) {
        for (int across = 0; across < 12; ++across) {
          const double s = (across + 0.5) / 12.0;
          EXPECT_NEAR(speed_at(fields, axis, down, along, across), 4e-3 * s * (1.0 - s) * (1.0 - 0.5 / 144.0), 5e-6)
              << "axis " << axis << ", " << along << " along, " << across << " across";
        }
      }
      Cell last{1, 5, 5};
      last = {axis == 0 ? (down ? 0 : 29) : 1, axis == 1 ? (down ? 0 : 29) : 1, axis == 2 ? (down ? 0 : 29) : 1};
      EXPECT_NEAR(fields.density_kg_per_m3[field_index(fields, last[0], last[1], last[2])], 1.0, 3e-5);
    }
  }
  const FieldBlock coarse = slit<float>(0, false);
  EXPECT_NEAR(speed_at(coarse, 0, false, 29, 5), 4e-3 * (5.5 / 12.0) * (6.5 / 12.0), 1e-5);
}

// Between a wall and a mirror the parabola is half of that between two walls, whichever of them is below.
TEST(Inflow, OfAParabolaBesideAMirrorIsHalfOfIt) {
  for (const bool wall_above : {false, true}) {
    FluidSetup setup = lattice_unit_setup({20, 8, 4}, 1.0 / 18.0, BoundaryKind::periodic);
    setup.boundaries[0] = {.kind = BoundaryKind::velocity, .velocity_m_per_s = {1e-3, 0, 0}, .parabolic = true};
    setup.boundaries[1].kind = BoundaryKind::outflow;
    setup.boundaries[wall_above ? 3 : 2].kind = BoundaryKind::no_slip;
    setup.boundaries[wall_above ? 2 : 3].kind = BoundaryKind::free_slip;
    FlowCase<double> flow(setup);
    flow.run(10000);
    const FieldBlock fields = flow.solver().fields();
    for (int y = 0; y < 8; ++y) {
      const double s = ((wall_above ? 7 - y : y) + 0.5) / 16.0;
      EXPECT_NEAR(fields.velocity_m_per_s[3 * field_index(fields, 10, y, 1)], 4e-3 * s * (1.0 - s), 6e-6) << y;
    }
  }
}

// Walls that move as fast as the stream leave it uniform up to the corners with the outflow.
TEST(Outflow, ReckonsWithWallsThatMove) {
  FluidSetup setup = lattice_unit_setup({20, 6, 4}, 1.0 / 18.0, BoundaryKind::periodic);
  const Boundary moving{.kind = BoundaryKind::velocity, .velocity_m_per_s = {0.02, 0, 0}};
  setup.boundaries[0] = setup.boundaries[2] = setup.boundaries[3] = moving;
  setup.boundaries[1].kind = BoundaryKind::outflow;
  setup.initial_flow = {.kind = InitialFlowKind::uniform, .velocity_m_per_s = {0.02, 0, 0}};
  FlowCase<double> flow(setup);
  flow.run(500);
  for (const double density : flow.solver().fields().density_kg_per_m3) EXPECT_NEAR(density, 1.0, 1e-13);
}

// An obstacle that reaches through an outflow disturbs nothing at rest: what it sends back is not counted as missing.
TEST(Outflow, LeavesFluidAtRestBesideAnObstacle) {
  FluidSetup setup = lattice_unit_setup({20, 16, 16}, 1.0 / 18.0, BoundaryKind::no_slip);
  setup.boundaries[1].kind = BoundaryKind::outflow;
  setup.bodies = {{ShapeKind::sphere, 4.0, 0.0}};
  FlowCase<double> flow(setup, resting({{19.3, 8.2, 8.1}}));
  flow.run(100);
  for (const double density : flow.solver().fields().density_kg_per_m3) EXPECT_NEAR(density, 1.0, 1e-14);
}

}  // namespace
}  // namespace copepod::fluid::validation
