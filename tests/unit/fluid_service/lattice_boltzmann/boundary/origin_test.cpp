#include "lattice_boltzmann/boundary/origin.hpp"

#include <set>

#include <gtest/gtest.h>

#include "ranks/block_partition.hpp"

namespace copepod::fluid {
namespace {

struct Case {
  std::array<BoundaryKind, 3> kinds;
  Cell cells;
  std::array<bool, 3> symmetry_planes;
  int ranks;
};

constexpr auto wall = BoundaryKind::no_slip;
constexpr auto periodic = BoundaryKind::periodic;
constexpr auto slip = BoundaryKind::free_slip;
constexpr auto pressure = BoundaryKind::pressure;

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

INSTANTIATE_TEST_SUITE_P(Faces, Origins,
                         testing::Values(Case{{wall, wall, wall}, {3, 4, 5}, {}, 1},
                                         Case{{periodic, wall, slip}, {3, 4, 5}, {}, 1},
                                         Case{{slip, periodic, periodic}, {4, 3, 2}, {}, 1},
                                         Case{{pressure, slip, wall}, {3, 3, 4}, {}, 1},
                                         Case{{wall, periodic, pressure}, {4, 4, 6}, {true, true, true}, 1},
                                         Case{{periodic, periodic, periodic}, {1, 1, 1}, {}, 1},
                                         Case{{periodic, periodic, slip}, {1, 2, 1}, {}, 1},
                                         Case{{wall, slip, wall}, {2, 1, 1}, {}, 1},
                                         Case{{periodic, slip, wall}, {6, 6, 6}, {false, true, false}, 4},
                                         Case{{periodic, periodic, periodic}, {4, 4, 4}, {}, 8},
                                         Case{{wall, wall, wall}, {5, 4, 3}, {}, 3}));

}  // namespace
}  // namespace copepod::fluid
