#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

/// Maps all of its bodies.
struct MapOfAll : BodyMap {
  using BodyMap::BodyMap;
  using BodyMap::update;
  bool update() {
    std::vector<std::int32_t> all(bodies().size());
    std::iota(all.begin(), all.end(), 0);
    return BodyMap::update(all);
  }
};

/// A boundary cell: its index, its place in the block, its links and its second cells.
using ListedCell = std::tuple<std::int64_t, Cell, std::uint32_t, std::uint32_t>;

/// Sorted by cell.
inline std::vector<ListedCell> listing(const BodySurface& surface, const PopulationLayout& layout) {
  std::vector<ListedCell> cells;
  for (const CellGroup& group : surface.groups)
    for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
      const Cell cell = {group.cell[0][lane], group.cell[1][lane], group.cell[2][lane]};
      if (group.directions[lane] != 0)
        cells.emplace_back(layout.cell(cell[0], cell[1], cell[2]), cell, group.directions[lane],
                           group.second_cells[lane]);
    }
  std::ranges::sort(cells);
  return cells;
}

}  // namespace copepod::fluid
