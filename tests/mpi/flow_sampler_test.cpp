#include "lattice_boltzmann/output/flow_sampler.hpp"

#include <cmath>
#include <iterator>

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
  return FlowSampler(setup, domain, block, ranks)(fields_of);
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

}  // namespace
}  // namespace copepod::fluid
