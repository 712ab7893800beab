#include "lattice_boltzmann/output/flow_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <vector>

#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "test_on_ranks.hpp"

namespace copepod::fluid {
namespace {

constexpr double cell_m = 0.5, step_s = 0.1, density = 1000.0, viscosity = 0.3;

/// 8 × 6 × 12 cells: periodic along x, the lower half of y is computed, walls at z.
FluidSetup half_channel() {
  FluidSetup setup;
  setup.domain_cells = {8, 6, 12};
  setup.cell_size_m = cell_m;
  setup.step_s = step_s;
  setup.density_kg_per_m3 = density;
  setup.kinematic_viscosity_m2_per_s = viscosity;
  setup.boundaries[0].kind = setup.boundaries[1].kind = BoundaryKind::periodic;
  setup.boundaries[2].kind = setup.boundaries[3].kind = BoundaryKind::free_slip;
  setup.symmetry_planes = {false, true, false};
  setup.flow.every_steps = 1;
  return setup;
}

/// Velocity (3 z, y, x) in m/s, relative density 1 + (x + 2 z)/100 in lengths of a cell; a body covers one cell.
FieldBlock fields_of(const Box& box) {
  FieldBlock block{.box = box, .density_kg_per_m3 = {}, .velocity_m_per_s = {}, .body = {}};
  for_each_cell(box, [&](const Cell& cell) {
    const double x = cell_m * (cell[0] + 0.5), y = cell_m * (cell[1] + 0.5), z = cell_m * (cell[2] + 0.5);
    block.velocity_m_per_s.insert(block.velocity_m_per_s.end(), {3.0 * z, y, x});
    block.density_kg_per_m3.push_back(density * (1.0 + 0.01 * (cell[0] + 2.0 * cell[2])));
    block.body.push_back(cell == Cell{6, 1, 8} ? 1 : 0);
  });
  return block;
}

/// Of all ranks; on rank 0.
Eigen::VectorXd sample(const FluidSetup& setup, Communicator& ranks) {
  const Domain domain(setup, LatticeUnits(setup));
  const Box block = BlockPartition(domain.cells(), ranks.size(), setup.bodies.size()).block(ranks.rank());
  return FlowSampler(setup, domain, block, ranks)(fields_of, [](const auto&) {});
}

/// Where the values of a probe are expected.
struct Place {
  const char* what;
  Eigen::Vector3d cells;  ///< from the corner of the domain
  Eigen::Vector4d value;  ///< velocity [m/s], excess density in per cent
};

TEST_ON_RANKS(FlowSampler, InterpolatesBetweenCellsAcrossMirrorsAndPeriodicFaces) {
  FluidSetup setup = half_channel();
  setup.flow.totals = false;
  const double h = cell_m;
  const Place places[] = {
      {"inside", {3.2, 1.7, 5.9}, {3 * 5.9 * h, 1.7 * h, 3.2 * h, 2.7 + 2 * 5.4}},
      {"the centre of a cell", {2.5, 0.5, 3.5}, {3 * 3.5 * h, 0.5 * h, 2.5 * h, 2 + 2 * 3}},
      {"in the mirror image", {3.2, 4.3, 5.9}, {3 * 5.9 * h, -1.7 * h, 3.2 * h, 2.7 + 2 * 5.4}},
      {"on the symmetry plane", {3.5, 3.0, 5.5}, {3 * 5.5 * h, 0, 3.5 * h, 3 + 2 * 5}},
      {"beside the far mirror", {3.5, 5.9, 5.5}, {3 * 5.5 * h, -0.1 * h, 3.5 * h, 3 + 2 * 5}},
      {"on the first face of a mirror", {3.5, 0.0, 5.5}, {3 * 5.5 * h, 0, 3.5 * h, 3 + 2 * 5}},
      {"on the periodic face", {0.0, 1.5, 5.5}, {3 * 5.5 * h, 1.5 * h, 4.0 * h, 3.5 + 2 * 5}},
      {"on the other one", {8.0, 1.5, 5.5}, {3 * 5.5 * h, 1.5 * h, 4.0 * h, 3.5 + 2 * 5}},
      {"beside a wall", {3.5, 1.5, 11.9}, {3 * 11.5 * h, 1.5 * h, 3.5 * h, 3 + 2 * 11}},
      {"between a body and the fluid", {6.5, 1.5, 8.25}, {3 * 8.25 * h, 1.5 * h, 6.5 * h, 6 + 2 * 7}},
      {"in a body", {6.5, 1.5, 8.5}, {3 * 8.5 * h, 1.5 * h, 6.5 * h, 0}},
  };
  for (const Place& place : places) setup.flow.probes.push_back({place.what, h * place.cells});
  const Eigen::VectorXd values = sample(setup, ranks);
  if (ranks.rank() != 0) return;
  ASSERT_EQ(values.size(), 4 * std::ssize(places));
  const double pressure_Pa = density * cell_m * cell_m / (3.0 * step_s * step_s);  // of an excess density of 1
  for (Eigen::Index i = 0; i < std::ssize(places); ++i) {
    Eigen::Vector4d expected = places[i].value;
    expected[3] *= 0.01 * pressure_Pa;
    EXPECT_LT((values.segment<4>(4 * i) - expected).norm(), 1e-9 * pressure_Pa) << places[i].what;
  }
}

TEST_ON_RANKS(FlowSampler, AddsUpAllFluidToTheSameBitsOnAnyNumberOfRanks) {
  FluidSetup setup = half_channel();
  setup.boundaries[0].kind = setup.boundaries[1].kind = BoundaryKind::pressure;  // differences are one-sided there
  setup.boundaries[4].kind = setup.boundaries[5].kind = BoundaryKind::pressure;
  setup.flow.probes.push_back({"probe", {1.0, 1.0, 1.0}});
  const Eigen::VectorXd values = sample(setup, ranks);
  if (ranks.rank() != 0) return;
  SolverContext context;
  SelfCommunicator self(context);
  EXPECT_EQ(values, sample(setup, self));

  double energy = 0.0;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  const FieldBlock all = fields_of({{0, 0, 0}, {8, 3, 12}});
  const double volume = std::pow(cell_m, 3);
  for (std::size_t i = 0; i < all.body.size(); ++i) {
    if (all.body[i] != 0) continue;
    const Eigen::Map<const Eigen::Vector3d> u(&all.velocity_m_per_s[3 * i]);
    energy += all.density_kg_per_m3[i] * volume * u.squaredNorm();  // twice ½ρu²: the mirror image has the same
    momentum += 2.0 * all.density_kg_per_m3[i] * volume * u;
  }
  // u = (3 z, y, x): ω_y = 2, S_xz = 2, S_yy = 1, but −2 beside the plane, where v turns round. A cell is a body's.
  const double cells = 8 * 3 * 12 - 1;
  const double strain = 8.0 * cells + 8 * 12 * (1 + 1 + 4) - 1;
  EXPECT_NEAR(values[0], energy, 1e-12 * energy);
  EXPECT_NEAR(values[1], 2.0 * 2.0 * density * viscosity * volume * strain, 1e-12 * values[1]);
  EXPECT_NEAR(values[2], 2.0 * 0.5 * 4.0 * volume * cells, 1e-12 * values[2]);
  EXPECT_NEAR(values[3], momentum.x(), 1e-12 * momentum.x());
  EXPECT_EQ(values[4], 0.0);
  EXPECT_NEAR(values[5], momentum.z(), 1e-12 * momentum.z());
}

/// A flow past a ball, at rest or with a moving surface, and a ledge that reaches through faces. Lengths in cells, and
/// so on.
struct Stream {
  const char* what;
  std::array<Boundary, 6> faces;
  std::array<bool, 3> symmetry_planes{};
  Precision precision = Precision::double_precision;
  bool spins = false;
};

Boundary moving(const Eigen::Vector3d& velocity) {
  return {.kind = BoundaryKind::velocity, .velocity_m_per_s = velocity};
}

const Boundary no_slip{}, free_slip{.kind = BoundaryKind::free_slip}, periodic{.kind = BoundaryKind::periodic},
    outflow{.kind = BoundaryKind::outflow}, at_pressure{.kind = BoundaryKind::pressure, .pressure_Pa = 2e-3},
    parabola{.kind = BoundaryKind::velocity, .velocity_m_per_s = {0.03, 0.0, 0.0}, .parabolic = true};

const Stream streams[] = {
    {"closed", {no_slip, no_slip, no_slip, no_slip, no_slip, no_slip}},
    {"lid", {no_slip, no_slip, no_slip, moving({0.05, 0, 0.02}), periodic, periodic}},
    {"between mirrors", {free_slip, free_slip, free_slip, no_slip, periodic, periodic}},
    {"parabola", {parabola, outflow, no_slip, no_slip, free_slip, no_slip}},
    {"oblique", {outflow, moving({-0.03, 0.02, 0}), moving({0, 0.01, 0}), outflow, periodic, periodic}},
    {"pressure", {at_pressure, outflow, no_slip, moving({0.04, 0, 0}), at_pressure, free_slip}},
    {"part of a duct", {parabola, outflow, no_slip, no_slip, free_slip, free_slip}, {false, true, true}},
    {"part of a box", {no_slip, no_slip, free_slip, free_slip, periodic, periodic}, {true, false, true}},
    {"single", {parabola, outflow, no_slip, free_slip, periodic, periodic}, {}, Precision::single_precision},
    {"past a spinning ball", {parabola, outflow, no_slip, free_slip, outflow, no_slip}, {}, {}, true},
};

FluidSetup setup_of(const Stream& stream) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 0.1;
  setup.domain_cells = {14, 12, 10};
  setup.boundaries = stream.faces;
  setup.symmetry_planes = stream.symmetry_planes;
  setup.precision = stream.precision;
  setup.body_force_N_per_m3 = {2e-5, -1e-5, 3e-5};
  for (int axis = 0; axis < 3; ++axis)
    if (stream.symmetry_planes[static_cast<std::size_t>(axis)]) setup.body_force_N_per_m3[axis] = 0.0;
  setup.obstacles = {{"ball", {.kind = ShapeKind::sphere, .radius_m = 2.3}, {7, 6, 5}},
                     {"ledge", {.kind = ShapeKind::box, .extents_m = {6, 3, 20}}, {7, 0, 5}}};
  if (stream.symmetry_planes[1]) setup.obstacles.pop_back();
  if (stream.spins) {
    setup.bodies = {setup.obstacles[0].shape};
    setup.obstacles.erase(setup.obstacles.begin());
  }
  for (ObstacleSpecification& obstacle : setup.obstacles) obstacle.loads = true;
  setup.flow.every_steps = 1;
  for (std::int64_t face = 0; face < 6; ++face)
    if (stream.faces[static_cast<std::size_t>(face)].kind != BoundaryKind::periodic) setup.flow.faces.push_back(face);
  return setup;
}

/// What the body force drives.
double cells_of_fluid(const FluidSetup& setup) {
  double count = 0.0;
  for_each_cell({{0, 0, 0}, setup.domain_cells}, [&](const Cell& cell) {
    const Eigen::Vector3d r(cell[0] - 6.5, cell[1] - 5.5, cell[2] - 4.5);
    const bool in_ledge = setup.obstacles.size() + setup.bodies.size() > 1 && std::abs(r[0]) < 3.0 && cell[1] < 1;
    count += r.norm() > 2.3 && !in_ledge ? 1.0 : 0.0;
  });
  return count;
}

/// Of each step of a start from rest, on rank 0.
struct History {
  std::vector<Loads> loads;
  std::vector<double> mass;
  std::uint64_t digest = 0;
};

History history_of(const FluidSetup& setup, Communicator& ranks) {
  const auto solver = make_lattice_boltzmann(setup, ranks);
  const auto cells = static_cast<double>(setup.domain_cells[0] * setup.domain_cells[1] * setup.domain_cells[2]);
  History history;
  Kinematics bodies;
  bodies.resize(std::ssize(setup.bodies));
  bodies.position_m.colwise() = Eigen::Vector3d(7, 6, 5);
  bodies.orientation_wxyz.colwise() = Eigen::Vector4d(1, 0, 0, 0);
  bodies.velocity_m_per_s.colwise() = Eigen::Vector3d(0.01, 0.02, 0.03);
  bodies.angular_velocity_rad_per_s.colwise() = Eigen::Vector3d(0.01, -0.02, 0.01);
  for (bodies.step = 0; bodies.step < 60; ++bodies.step) {
    solver->exchange(bodies, history.loads.emplace_back());
    const SolverSummary summary = solver->summarise();
    history.mass.push_back(cells * summary.mass_drift.value_or(0.0));
    history.digest = summary.digest;
    solver->advance();
  }
  return history;
}

// With bounce_back a fluid loses momentum to bodies and faces only.
TEST_ON_RANKS(FlowSampler, ForcesOnFacesAndWhatComesInAreAllThatAFluidLosesAndGains) {
  for (const Stream& stream : streams) {
    const FluidSetup setup = setup_of(stream);
    FluidSetup unsampled = setup;
    unsampled.flow.every_steps = 0;
    const History history = history_of(setup, ranks);
    if (ranks.rank() != 0) continue;
    SolverContext context;
    SelfCommunicator self(context);
    const History alone = history_of(setup, self);
    EXPECT_EQ(history.digest, history_of(unsampled, self).digest) << stream.what;
    const double tolerance = stream.precision == Precision::single_precision ? 2e-4 : 1e-11;
    const auto momentum = [](const Loads& loads) -> Eigen::Vector3d { return loads.flow.segment<3>(3); };
    double largest_flow = 0.0, largest_force = 0.0;
    for (std::size_t step = 0; step + 1 < history.loads.size(); ++step) {
      const Loads& loads = history.loads[step];
      ASSERT_EQ(loads.flow, alone.loads[step].flow) << stream.what << ", step " << step;
      const Eigen::Map<const Eigen::Matrix4Xd> faces(&loads.flow[6], 4, std::ssize(setup.flow.faces));
      const Eigen::Vector3d lost = loads.force_N.rowwise().sum() + faces.bottomRows<3>().rowwise().sum();
      const Eigen::Vector3d gained = momentum(history.loads[step + 1]) - momentum(loads) + lost;
      EXPECT_LT((gained - cells_of_fluid(setup) * setup.body_force_N_per_m3).norm(), tolerance) << stream.what;
      if (!stream.spins) {  // a surface that moves takes up mass and gives it back
        EXPECT_NEAR(faces.row(0).sum(), history.mass[step + 1] - history.mass[step], tolerance) << stream.what;
      }
      largest_flow = std::max(largest_flow, faces.row(0).cwiseAbs().maxCoeff());
      largest_force = std::max(largest_force, faces.bottomRows<3>().cwiseAbs().maxCoeff());
      for (Eigen::Index i = 0; i < faces.cols(); ++i) {
        const auto face = static_cast<std::size_t>(setup.flow.faces[static_cast<std::size_t>(i)]);
        const BoundaryKind kind = setup.boundaries[face].kind;
        const bool is_closed = kind == BoundaryKind::no_slip || kind == BoundaryKind::free_slip;
        EXPECT_TRUE(!is_closed || faces(0, i) == 0.0) << stream.what << ", " << face_names[face];
      }
    }
    const bool is_closed = std::ranges::none_of(setup.boundaries, [](const Boundary& face) {
      return face.kind == BoundaryKind::outflow || face.kind == BoundaryKind::pressure;
    });
    EXPECT_EQ(largest_flow > 0.1, !is_closed) << stream.what;
    EXPECT_GT(largest_force, 1e-3) << stream.what;
  }
}

/// The last of many samples.
Eigen::VectorXd steady(const FluidSetup& setup, int steps) {
  SolverContext context;
  SelfCommunicator self(context);
  const auto solver = make_lattice_boltzmann(setup, self);
  Kinematics none;
  none.resize(0);
  Loads loads;
  for (none.step = 0; none.step < steps; ++none.step) {
    solver->exchange(none, loads);
    solver->advance();
  }
  return loads.flow;
}

/// 12 cells between two faces normal to y, all others periodic, or as they are.
FluidSetup slit(const std::array<Boundary, 2>& walls, const std::array<Boundary, 2>& ends) {
  FluidSetup setup = setup_of({"slit", {ends[0], ends[1], walls[0], walls[1], periodic, periodic}});
  setup.domain_cells = {30, 12, 4};
  setup.cell_size_m = 0.5;
  setup.step_s = 0.25;
  setup.density_kg_per_m3 = 1000.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 6.0;
  setup.collision = CollisionKind::trt;
  setup.body_force_N_per_m3.setZero();
  setup.obstacles.clear();
  setup.flow = {.every_steps = 500, .totals = false, .probes = {}, .faces = setup.flow.faces};
  return setup;
}

// τ = ρ ν U/h on the wall at rest, and the opposite on the one that moves.
TEST(FacesOfASlit, HaveTheShearOfCouetteFlow) {
  const Eigen::VectorXd found = steady(slit({no_slip, moving({0.01, 0, 0.02})}, {periodic, periodic}), 5001);
  const double shear_N = 1000.0 / 6.0 * 0.01 / 6.0 * 15.0 * 2.0;
  ASSERT_EQ(found.size(), 8);
  for (const int wall : {0, 1}) {
    EXPECT_NEAR(found[4 * wall + 1], (wall == 0 ? 1 : -1) * shear_N, 1e-8 * shear_N);
    EXPECT_NEAR(found[4 * wall + 3], (wall == 0 ? 2 : -2) * shear_N, 1e-8 * shear_N);
    EXPECT_NEAR(found[4 * wall + 2], 0.0, 1e-3 * shear_N);
  }
}

// Half of what drives it on each wall; likewise of half a slit, for the whole.
TEST(FacesOfASlit, ShareTheForceThatDrivesPoiseuilleFlow) {
  for (const bool is_half : {false, true}) {
    FluidSetup setup = slit({no_slip, no_slip}, {periodic, periodic});
    setup.symmetry_planes = {false, is_half, is_half};
    setup.body_force_N_per_m3[0] = 0.1;
    const Eigen::VectorXd found = steady(setup, 7001);
    const double driving_N = 0.1 * 15.0 * 6.0 * 2.0;
    for (const int wall : {0, 1}) EXPECT_NEAR(found[4 * wall + 1], 0.5 * driving_N, 1e-6 * driving_N) << is_half;
  }
}

// What comes in leaves, and the walls have the shear of all their length; on n cells the parabola of a flow rate is
// lower by 1/(2n²).
TEST(FacesOfASlit, HaveWhatFlowsThroughAndTheDropOfPressure) {
  const Boundary inflow{.kind = BoundaryKind::velocity, .velocity_m_per_s = {0.001, 0, 0}, .parabolic = true};
  const Eigen::VectorXd found = steady(slit({no_slip, no_slip}, {inflow, outflow}), 20001);
  ASSERT_EQ(found.size(), 16);
  const double flow = 2.0 / 3.0 * 0.001 * 6.0 * 2.0;
  EXPECT_NEAR(found[0], flow, 1e-9 * flow);
  EXPECT_NEAR(found[4], -found[0], 2e-6 * flow);
  EXPECT_EQ(found[8], 0.0);
  const double drop_Pa = 12.0 * 1000.0 / 6.0 * flow / (6 * 6 * 6 * 2.0) * 15.0 / (1.0 + 0.5 / 144.0);
  const double wall_N = 0.5 * drop_Pa * 6.0 * 2.0;
  EXPECT_NEAR(found[9], wall_N, 0.002 * wall_N);
  EXPECT_NEAR(found[9], found[13], 1e-9 * wall_N);
  EXPECT_NEAR(-found[1] - found[5], 2.0 * wall_N, 0.002 * wall_N);
  // The pressure is that at rest in the middle of the last cell; there is also the momentum of the parabola.
  const double mean = flow / (6.0 * 2.0), leaving_N = 1.2 * 1000.0 * mean * mean * 6.0 * 2.0;
  EXPECT_NEAR(found[5], leaving_N - drop_Pa / 60.0 * 6.0 * 2.0, 0.001 * wall_N);
}

// Also while it begins to flow and the shear differs from place to place.
TEST(FacesOfASlit, AreThoseOfTheMirrorImage) {
  Boundary inflow{.kind = BoundaryKind::velocity, .velocity_m_per_s = {0.001, 0, 0}};
  FluidSetup setup = slit({no_slip, free_slip}, {inflow, outflow});
  setup.flow.every_steps = 30;
  const Eigen::VectorXd found = steady(setup, 31);
  inflow.velocity_m_per_s *= -1.0;
  setup.boundaries[0] = outflow;
  setup.boundaries[1] = inflow;
  const Eigen::VectorXd image = steady(setup, 31);
  for (int value = 0; value < 4; ++value) {
    const double sign = value == 1 ? -1.0 : 1.0;
    for (const int face : {0, 1, 2, 3})
      EXPECT_NEAR(image[4 * (face < 2 ? 1 - face : face) + value], sign * found[4 * face + value],
                  1e-12 * found.cwiseAbs().maxCoeff())
          << face << ", " << value;
  }
}

}  // namespace
}  // namespace copepod::fluid
