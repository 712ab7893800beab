#include "lattice_boltzmann/boundary/domain.hpp"

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"

namespace copepod::fluid {
namespace {

FluidSetup box_of(BoundaryKind x, BoundaryKind y, BoundaryKind z) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.domain_cells = {8, 6, 10};
  const BoundaryKind kinds[3] = {x, y, z};
  for (int axis = 0; axis < 3; ++axis)
    setup.boundaries[2 * axis].kind = setup.boundaries[2 * axis + 1].kind = kinds[axis];
  return setup;
}

Domain domain_of(const FluidSetup& setup) { return {setup, LatticeUnits(setup)}; }

constexpr auto wall = BoundaryKind::no_slip;
constexpr auto periodic = BoundaryKind::periodic;
constexpr auto slip = BoundaryKind::free_slip;

TEST(Domain, SymmetryPlaneHalvesTheComputedDomain) {
  FluidSetup setup = box_of(wall, wall, wall);
  setup.symmetry_planes = {true, false, false};
  const Domain domain = domain_of(setup);
  EXPECT_EQ(domain.cells(), (Cell{4, 6, 10}));
  EXPECT_EQ(domain.canonical({4, 2, 2}), (Cell{3, 2, 2}));
  EXPECT_EQ(domain.canonical({-1, 2, 2}), std::nullopt);
}

TEST(Domain, PeriodicAndSymmetricMeansMirrorsOnBothSides) {
  FluidSetup setup = box_of(periodic, wall, wall);
  setup.symmetry_planes = {true, false, false};
  const Domain domain = domain_of(setup);
  EXPECT_FALSE(domain.periodic(0));
  EXPECT_EQ(domain.canonical({-1, 2, 2}), (Cell{0, 2, 2}));
}

TEST(Domain, RefusesAnOddNumberOfCellsWithASymmetryPlane) {
  FluidSetup setup = box_of(wall, wall, wall);
  setup.domain_cells = {7, 6, 10};
  setup.symmetry_planes = {true, false, false};
  EXPECT_THROW(domain_of(setup), CaseError);
}

TEST(Domain, RefusesOnePeriodicFace) {
  FluidSetup setup = box_of(wall, wall, wall);
  setup.boundaries[4].kind = periodic;
  EXPECT_THROW(domain_of(setup), CaseError);
}

TEST(Domain, DistancesGoToTheNearestPeriodicImage) {
  const Domain domain = domain_of(box_of(periodic, wall, wall));
  EXPECT_DOUBLE_EQ(domain.from_position({7.5, 3.0, 3.0}, {0, 2, 2})[0], 1.0);
  EXPECT_DOUBLE_EQ(domain.from_position({15.5, 3.0, 3.0}, {0, 2, 2})[0], 1.0);
}

TEST(GhostSource, WallSendsThePopulationBackToTheCellItLeft) {
  const int up = d3q19::index_of({0, 0, 1});
  const GhostSource source = ghost_source(domain_of(box_of(wall, wall, wall)), {3, 3, -1}, up);
  EXPECT_EQ(source.cell, (Cell{3, 3, 0}));
  EXPECT_EQ(source.direction, d3q19::opposite(up));
  EXPECT_EQ(source.addition, 0.0);
}

TEST(GhostSource, SlidingWallAddsItsMomentum) {
  FluidSetup setup = box_of(periodic, periodic, wall);
  setup.boundaries[4] = {BoundaryKind::velocity, Eigen::Vector3d(0.01, 0.0, 0.0), 0.0};
  const int diagonal = d3q19::index_of({1, 0, 1});
  const GhostSource source = ghost_source(domain_of(setup), {3, 3, -1}, diagonal);
  EXPECT_EQ(source.cell, (Cell{4, 3, 0}));
  EXPECT_DOUBLE_EQ(source.addition, 6.0 / 36.0 * 0.01);
}

TEST(GhostSource, PeriodicFaceTakesTheSameDirectionFromTheOtherEnd) {
  const int up = d3q19::index_of({0, 0, 1});
  const GhostSource source = ghost_source(domain_of(box_of(wall, wall, periodic)), {3, 3, -1}, up);
  EXPECT_EQ(source.cell, (Cell{3, 3, 9}));
  EXPECT_EQ(source.direction, up);
}

TEST(GhostSource, FreeSlipReflectsTheNormalComponentOnly) {
  const GhostSource source =
      ghost_source(domain_of(box_of(slip, wall, wall)), {-1, 3, 3}, d3q19::index_of({1, 1, 0}));
  EXPECT_EQ(source.cell, (Cell{0, 3, 3}));
  EXPECT_EQ(source.direction, d3q19::index_of({-1, 1, 0}));
}

TEST(GhostSource, WallWinsInAnEdgeWithAPeriodicFace) {
  const int diagonal = d3q19::index_of({1, 0, 1});
  const GhostSource source = ghost_source(domain_of(box_of(periodic, wall, wall)), {-1, 3, -1}, diagonal);
  EXPECT_EQ(source.cell, (Cell{0, 3, 0}));
  EXPECT_EQ(source.direction, d3q19::opposite(diagonal));
}

}  // namespace
}  // namespace copepod::fluid
