#include <cmath>
#include <cstdio>
#include <string>
#include <unistd.h>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "ranks/block_partition.hpp"
#include "test_on_ranks.hpp"
#include "voxel_shape.hpp"

namespace copepod::fluid {
namespace {

/// A sphere and a tilted capsule, or a concave mesh and an ellipsoid beside an obstacle, that wander and turn through a
/// small box: across rank borders, periodic faces, and each other's wakes. Everything that could depend on the
/// decomposition happens within the steps of the test.
struct Method {
  Precision precision = Precision::double_precision;
  MovingBoundary moving_boundary = MovingBoundary::bounce_back;
  Refill refill = Refill::equilibrium;
  bool has_open_faces = false;
  bool has_other_shapes = false;
  bool has_stream = false;
  CollisionKind collision = CollisionKind::bgk;
};

FluidSetup wandering_bodies(const Method& method) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = {16, 18, 22};
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::periodic;
  setup.boundaries[2].kind = setup.boundaries[3].kind =
      method.has_open_faces ? BoundaryKind::pressure : BoundaryKind::no_slip;
  if (method.has_open_faces) setup.boundaries[2].pressure_Pa = 2e-3;
  if (method.has_stream) {
    setup.boundaries[2] = {BoundaryKind::velocity, {0.01, 0.02, 0.0}, 0.0};
    setup.boundaries[2].signal = {.kind = SignalKind::sinusoid, .amplitude = 1.0, .period_steps = 70, .table = {}};
    for (int cell = 0; cell < 16 * 22; ++cell) setup.boundaries[2].profile.push_back(1.0 + 0.2 * std::sin(cell));
    setup.boundaries[3].kind = BoundaryKind::outflow;
  }
  setup.precision = method.precision;
  setup.collision = method.collision;
  setup.moving_boundary = method.moving_boundary;
  setup.refill = method.refill;
  setup.flow = {.every_steps = 3, .totals = false, .probes = {}, .faces = {2, 3}};
  setup.bodies = {{ShapeKind::sphere, 3.0, 0.0}, {ShapeKind::capsule, 2.0, 3.0}};
  if (method.has_other_shapes)
    setup.bodies = {doubles::voxel_shape({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 1, 0}, {0, 1, 0}}, 2.0, {1.5, 0.7, 0.5}),
                    {.kind = ShapeKind::ellipsoid, .radius_m = 2.4, .extents_m = {1.8, 2.5, 3.0}}};
  if (method.has_other_shapes && !method.has_open_faces)  // beyond the wall
    setup.obstacles = {{"ledge", {.kind = ShapeKind::box, .extents_m = {9.0, 3.0, 15.0}}, {8.0, 18.2, 11.0}}};
  return setup;
}

Kinematics wandering_kinematics(std::int64_t step) {
  const auto t = static_cast<double>(step);
  Kinematics kinematics;
  kinematics.resize(2);
  kinematics.step = step;
  kinematics.position_m.col(0) << 2.0 + 0.03 * t, 6.0 + std::sin(0.02 * t), 4.0 + 0.02 * t;
  kinematics.position_m.col(1) << 12.0 - 0.02 * t, 12.5, 16.0 + 0.04 * t;
  kinematics.orientation_wxyz.col(0) << std::cos(0.01 * t), 0.0, std::sin(0.01 * t), 0.0;
  kinematics.orientation_wxyz.col(1) << std::cos(0.01 * t), std::sin(0.01 * t), 0.0, 0.0;
  kinematics.velocity_m_per_s.col(0) << 0.03, 0.02 * std::cos(0.02 * t), 0.02;
  kinematics.velocity_m_per_s.col(1) << -0.02, 0.0, 0.04;
  kinematics.angular_velocity_rad_per_s.col(0) << 0.0, 0.02, 0.0;
  kinematics.angular_velocity_rad_per_s.col(1) << 0.02, 0.0, 0.0;
  return kinematics;
}

struct Outcome {
  SolverSummary summary;
  Loads loads;
};

Outcome run(FluidSolver& solver, std::int64_t from, std::int64_t to) {
  Outcome outcome;
  for (std::int64_t step = from; step < to; ++step) {
    solver.exchange(wandering_kinematics(step), outcome.loads);
    solver.advance();
  }
  outcome.summary = solver.summarise();
  return outcome;
}

class Decomposition : public testing::TestWithParam<Method> {};

TEST_P_ON_RANKS(Decomposition, GivesTheBitsOfOneRank) {
  const FluidSetup setup = wandering_bodies(parameter);
  const Outcome distributed = run(*make_lattice_boltzmann(setup, ranks), 0, 400);
  if (ranks.rank() != 0) return;
  SolverContext own_context;
  SelfCommunicator self{own_context};
  const Outcome alone = run(*make_lattice_boltzmann(setup, self), 0, 400);
  EXPECT_EQ(distributed.summary.digest, alone.summary.digest);
  EXPECT_EQ(distributed.loads.flow, alone.loads.flow);
  EXPECT_EQ(distributed.loads.flow.size(), 8);
  EXPECT_EQ(distributed.summary.mass_drift, alone.summary.mass_drift);
  EXPECT_EQ(distributed.summary.momentum_drift, alone.summary.momentum_drift);
  EXPECT_GT(alone.summary.momentum_drift.value(), 1e-4);
  EXPECT_EQ(distributed.loads.force_N, alone.loads.force_N);
  EXPECT_EQ(distributed.loads.torque_N_m, alone.loads.torque_N_m);
  EXPECT_GT(alone.loads.force_N.norm(), 1e-3);
}

// Saved and restored after an odd number of steps, when the populations lie in their neighbours' slots.
TEST_P_ON_RANKS(Decomposition, ContinuesFromACheckpointWithTheSameBits) {
  const FluidSetup setup = wandering_bodies(parameter);
  std::int64_t tag[1] = {getpid()};
  ranks.max_to_all(tag);
  const std::string path = testing::TempDir() + "decomposition_" + std::to_string(tag[0]) + ".h5";

  const auto undisturbed = make_lattice_boltzmann(setup, ranks);
  run(*undisturbed, 0, 151);
  undisturbed->save(path);
  const Outcome expected = run(*undisturbed, 151, 300);

  const auto resumed = make_lattice_boltzmann(setup, ranks);
  resumed->restore(path);
  const Outcome continued = run(*resumed, 151, 300);
  if (ranks.rank() == 0) {
    EXPECT_EQ(continued.summary.digest, expected.summary.digest);
    EXPECT_EQ(continued.summary.momentum_drift, expected.summary.momentum_drift);
    EXPECT_EQ(continued.loads.force_N, expected.loads.force_N);
  }
  ranks.max_to_all(tag);
  if (ranks.rank() == 0) std::remove(path.c_str());
}

/// Torque about z, by u R³, of the first step on a free sphere whose surface moves at u = 0.1 around z.
double first_torque(double radius, const Method& method, Communicator& communicator) {
  FluidSetup setup = wandering_bodies(method);
  const auto cells = static_cast<std::int64_t>(2.0 * radius) + 4;
  setup.domain_cells = {cells, cells, cells};
  setup.boundaries[2].profile.clear();
  setup.bodies = {{ShapeKind::sphere, radius, 0.0}};
  setup.obstacles.clear();
  Kinematics spinning;
  spinning.resize(1);
  spinning.position_m.setConstant(0.5 * static_cast<double>(cells));
  spinning.orientation_wxyz << 1.0, 0.0, 0.0, 0.0;
  spinning.velocity_m_per_s.setZero();
  spinning.angular_velocity_rad_per_s << 0.0, 0.0, 0.1 / radius;
  Loads loads;
  const auto solver = make_lattice_boltzmann(setup, communicator);
  solver->exchange(spinning, loads);
  solver->advance();
  return communicator.rank() == 0 ? loads.torque_N_m(2, 0) / (0.1 * radius * radius * radius) : 0.0;
}

// The torque of a sphere of radius 32 is -10⁴ in lattice units: more than 64 bits of the unit hold.
TEST_P_ON_RANKS(Decomposition, SumsTheTorqueOfABigSphereToTheSameBits) {
  const double distributed = first_torque(32.0, parameter, ranks);
  if (ranks.rank() != 0) return;
  SolverContext own_context;
  SelfCommunicator self{own_context};
  EXPECT_EQ(distributed, first_torque(32.0, parameter, self));
  EXPECT_NEAR(distributed / first_torque(16.0, parameter, self), 1.0, 0.05);
}

// So a flow that diverges ends a run in the same step on any number of ranks: the ranks look at one row together here.
TEST_ON_RANKS(Divergence, IsLookedForInStepsThatDoNotDependOnTheRanks) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 6.0;
  setup.domain_cells = {6, 5, 4};
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::periodic;
  setup.initial_flow = {InitialFlowKind::uniform, {0.45, 0.0, 0.0}, 0.0};
  const auto solver = make_lattice_boltzmann(setup, ranks);
  const Box block = BlockPartition(setup.domain_cells, ranks.size()).block(ranks.rank());
  constexpr std::int64_t rows = 30;
  Loads loads;
  for (std::int64_t step = 1; step <= 2 * rows; ++step) {
    Kinematics no_bodies;
    no_bodies.step = step - 1;
    solver->exchange(no_bodies, loads);
    bool noticed = false;
    try {
      solver->advance();
    } catch (const SolverError&) {
      noticed = true;
    }
    EXPECT_EQ(noticed, block.contains({step % rows / 5, step % 5, block.low[2]})) << "step " << step;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods, Decomposition,
    testing::Values(Method{}, Method{Precision::single_precision},
                    Method{Precision::single_precision, MovingBoundary::interpolated, Refill::grad},
                    Method{Precision::double_precision, MovingBoundary::parabolic, Refill::nonequilibrium},
                    Method{.has_open_faces = true}, Method{.has_stream = true},
                    Method{Precision::single_precision, MovingBoundary::parabolic, Refill::nonequilibrium, true},
                    Method{Precision::double_precision, MovingBoundary::central_linear, Refill::grad, false, true},
                    Method{Precision::single_precision, MovingBoundary::parabolic, Refill::nonequilibrium, false, true},
                    Method{Precision::single_precision, MovingBoundary::parabolic, Refill::nonequilibrium, false, true,
                           true},
                    Method{.moving_boundary = MovingBoundary::parabolic,
                           .refill = Refill::grad,
                           .has_stream = true,
                           .collision = CollisionKind::central_moments}),
    [](const auto& instance) {
      std::string name = instance.param.precision == Precision::double_precision ? "Double_" : "Single_";
      name += name_of(moving_boundary_names, instance.param.moving_boundary);
      if (instance.param.has_open_faces) name += "OpenFaces";
      if (instance.param.has_other_shapes) name += "OtherShapes";
      if (instance.param.has_stream) name += "Stream";
      if (instance.param.collision == CollisionKind::central_moments) name += "CentralMoments";
      std::erase(name, '_');
      return name;
    });

}  // namespace
}  // namespace copepod::fluid
