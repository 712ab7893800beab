#include "lattice_boltzmann/boundary/domain.hpp"

#include <set>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "ranks/block_partition.hpp"

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
constexpr auto pressure = BoundaryKind::pressure;

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

TEST(Domain, HasTheMeanProfileOfBothCellsOfALink) {
  FluidSetup setup = box_of(wall, wall, periodic);
  setup.domain_cells = {4, 3, 2};
  setup.boundaries[0] = {BoundaryKind::velocity, {1.0, 0.0, 0.0}};
  setup.boundaries[0].profile = {1, 2, 3, 4, 5, 6};  // y0 z0, y0 z1, y1 z0, …
  setup.symmetry_planes = {false, false, true};
  const Domain domain = domain_of(setup);
  EXPECT_EQ(domain.profile(0, false, {-1, 1, 0}, d3q19::index_of({1, 0, 0})), 3.0);
  EXPECT_EQ(domain.profile(0, false, {-1, 1, 0}, d3q19::index_of({1, 1, 0})), 4.0);
  EXPECT_EQ(domain.profile(0, false, {-1, 3, 0}, d3q19::index_of({1, -1, 0})), 5.0);
  EXPECT_EQ(domain.profile(0, false, {-1, 1, 1}, d3q19::index_of({1, 0, -1})), 3.0);
  setup.boundaries[0].profile.pop_back();
  EXPECT_THROW(domain_of(setup), CaseError);
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
  const GhostSource source = ghost_source(domain_of(box_of(slip, wall, wall)), {-1, 3, 3}, d3q19::index_of({1, 1, 0}));
  EXPECT_EQ(source.cell, (Cell{0, 3, 3}));
  EXPECT_EQ(source.direction, d3q19::index_of({-1, 1, 0}));
}

TEST(GhostSource, WallWinsInAnEdgeWithAPeriodicFace) {
  const int diagonal = d3q19::index_of({1, 0, 1});
  const GhostSource source = ghost_source(domain_of(box_of(periodic, wall, wall)), {-1, 3, -1}, diagonal);
  EXPECT_EQ(source.cell, (Cell{0, 3, 0}));
  EXPECT_EQ(source.direction, d3q19::opposite(diagonal));
}

TEST(GhostSource, OpenFaceReplacesThePopulationThatLeaves) {
  const GhostSource source =
      ghost_source(domain_of(box_of(pressure, wall, wall)), {-1, 3, 3}, d3q19::index_of({1, 0, 0}));
  EXPECT_EQ(source.kind, GhostSource::Kind::open);
  EXPECT_EQ(source.cell, (Cell{0, 3, 3}));
}

TEST(GhostSource, WallWinsInAnEdgeWithAnOpenFace) {
  const int diagonal = d3q19::index_of({1, 1, 0});
  EXPECT_EQ(ghost_source(domain_of(box_of(pressure, wall, wall)), {-1, -1, 3}, diagonal).kind, GhostSource::Kind::wall);
  EXPECT_EQ(ghost_source(domain_of(box_of(wall, pressure, wall)), {-1, -1, 3}, diagonal).kind, GhostSource::Kind::wall);
}

TEST(GhostSource, WallWinsInAnEdgeWithAnInflowAndOfTwoInflowsTheLater) {
  FluidSetup setup = box_of(wall, wall, wall);
  setup.boundaries[0] = {BoundaryKind::velocity, Eigen::Vector3d(0.01, 0.0, 0.0)};
  const int diagonal = d3q19::index_of({1, 1, 0});
  const auto addition = [&] { return ghost_source(domain_of(setup), {-1, -1, 3}, diagonal).addition; };
  EXPECT_EQ(addition(), 0.0);
  setup.boundaries[2] = {BoundaryKind::velocity, Eigen::Vector3d(0.0, 0.03, 0.0)};
  EXPECT_DOUBLE_EQ(addition(), 6.0 / 36.0 * 0.03);
}

struct Case {
  std::array<BoundaryKind, 3> kinds;
  Cell cells;
  std::array<bool, 3> symmetry_planes;
  int ranks;
};

class Origins : public testing::TestWithParam<Case> {
 protected:
  Origins() : domain_(setup(), LatticeUnits(setup())), partition_(domain_.cells(), GetParam().ranks) {}

  static FluidSetup setup() {
    FluidSetup setup;
    setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
    setup.domain_cells = GetParam().cells;
    setup.symmetry_planes = GetParam().symmetry_planes;
    for (std::size_t face = 0; face < 6; ++face) setup.boundaries[face].kind = GetParam().kinds[face / 2];
    return setup;
  }

  /// visit(layout of a block, cell of the domain, direction that enters it), for every rank.
  template <class Visit>
  void for_each_entry(const Visit& visit) const {
    for (int rank = 0; rank < partition_.ranks(); ++rank) {
      const Box block = partition_.block(rank);
      const PopulationLayout layout(block, 8, origin_rule(domain_, block));
      for (std::int64_t x = block.low[0]; x < block.high[0]; ++x)
        for (std::int64_t y = block.low[1]; y < block.high[1]; ++y)
          for (std::int64_t z = block.low[2]; z < block.high[2]; ++z)
            for (int alpha = 0; alpha < d3q19::directions; ++alpha) visit(layout, Cell{x, y, z}, alpha);
    }
  }

  Domain domain_;
  BlockPartition partition_;
};

TEST_P(Origins, EveryPopulationOfABlockHasASlotOfItsOwnInBothPlacements) {
  for (const Placement placement : {Placement::home, Placement::streamed}) {
    std::set<std::int64_t> taken;
    Box block;
    for_each_entry([&](const PopulationLayout& layout, const Cell& cell, int alpha) {
      if (layout.block() != block) taken.clear();
      block = layout.block();
      const std::int64_t location = layout.location(layout.site(cell), alpha, placement);
      EXPECT_TRUE(taken.insert(location).second);
      EXPECT_GE(location, 0);
      EXPECT_LT(location, layout.values());
    });
  }
}

TEST_P(Origins, WhatEntersIsReadWhereItsSourceLeftIt) {
  for_each_entry([&](const PopulationLayout& layout, const Cell& cell, int alpha) {
    const auto& e = d3q19::e[static_cast<std::size_t>(alpha)];
    const Cell behind = {cell[0] - e[0], cell[1] - e[1], cell[2] - e[2]};
    const GhostSource source = ghost_source(domain_, behind, alpha);
    if (!layout.block().contains(source.cell)) return;  // arrives in a message
    for (const Placement placement : {Placement::home, Placement::streamed})
      EXPECT_EQ(layout.entry(layout.site(cell), alpha, placement),
                layout.location(layout.site(source.cell), source.direction, placement));
  });
}

INSTANTIATE_TEST_SUITE_P(
    Faces, Origins,
    testing::Values(Case{{wall, wall, wall}, {3, 4, 5}, {}, 1}, Case{{periodic, wall, slip}, {3, 4, 5}, {}, 1},
                    Case{{slip, periodic, periodic}, {4, 3, 2}, {}, 1}, Case{{pressure, slip, wall}, {3, 3, 4}, {}, 1},
                    Case{{wall, periodic, pressure}, {4, 4, 6}, {true, true, true}, 1},
                    Case{{periodic, periodic, periodic}, {1, 1, 1}, {}, 1},
                    Case{{periodic, periodic, slip}, {1, 2, 1}, {}, 1}, Case{{wall, slip, wall}, {2, 1, 1}, {}, 1},
                    Case{{periodic, slip, wall}, {6, 6, 6}, {false, true, false}, 4},
                    Case{{periodic, periodic, periodic}, {4, 4, 4}, {}, 8},
                    Case{{wall, wall, wall}, {5, 4, 3}, {}, 3}));

}  // namespace
}  // namespace copepod::fluid
