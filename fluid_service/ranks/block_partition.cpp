#include "ranks/block_partition.hpp"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>

#include "contract/errors.hpp"

namespace copepod::fluid {

namespace {

using Grid = std::array<int, 3>;

/// Time that rank 0 needs for a body, in cell updates: it sends its state and adds up its loads
/// (docs/results/scaling.md has the measurement).
constexpr std::int64_t cells_per_body = 10;

/// Time of one step of the largest block, in tenths of a cell update.
///
/// Packing, copying and unpacking one face cell costs 0.8 cell updates normal to x, 1.3 normal to y and 7
/// normal to z: rows along z are contiguous in memory, so a face normal to z touches one cache line per value
/// (docs/decisions/partition_cost.md has the measurement).
std::int64_t step_cost(const Cell& cells, const Grid& grid) {
  constexpr std::array<std::int64_t, 3> face_cost = {8, 13, 70};
  constexpr std::int64_t cell_cost = 10;
  Cell extent;
  for (int axis = 0; axis < 3; ++axis) extent[axis] = (cells[axis] + grid[axis] - 1) / grid[axis];
  std::int64_t cost = cell_cost * extent[0] * extent[1] * extent[2];
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t faces = std::min(2, grid[axis] - 1);
    cost += faces * face_cost[axis] * extent[(axis + 1) % 3] * extent[(axis + 2) % 3];
  }
  return cost;
}

/// The cheapest grid of `ranks` blocks without an empty one; among equals the one cut most often normal to x.
std::optional<Grid> cheapest_grid(const Cell& cells, int ranks) {
  std::optional<Grid> best;
  std::int64_t lowest = std::numeric_limits<std::int64_t>::max();
  for (int px = ranks; px >= 1; --px) {
    if (ranks % px != 0 || px > cells[0]) continue;
    const int rest = ranks / px;
    for (int py = rest; py >= 1; --py) {
      if (rest % py != 0 || py > cells[1] || rest / py > cells[2]) continue;
      const Grid grid = {px, py, rest / py};
      const std::int64_t cost = step_cost(cells, grid);
      if (cost >= lowest) continue;
      lowest = cost;
      best = grid;
    }
  }
  return best;
}

CaseError no_grid(const Cell& cells, int ranks) {
  const std::string size =
      std::to_string(cells[0]) + "×" + std::to_string(cells[1]) + "×" + std::to_string(cells[2]) + " cells";
  if (ranks > cells[0] * cells[1] * cells[2])
    return CaseError("ranks " + std::to_string(ranks) + " (the computed domain has only " + size + "). Use at most " +
                     std::to_string(cells[0] * cells[1] * cells[2]) + " ranks.");
  int fewer = ranks - 1;
  while (!cheapest_grid(cells, fewer)) --fewer;  // ends at 1 rank at the latest
  return CaseError("ranks " + std::to_string(ranks) + " (the computed domain of " + size +
                   " cannot be cut into so many blocks without an empty one). Use " + std::to_string(fewer) +
                   " ranks.");
}

}  // namespace

BlockPartition::BlockPartition(const Cell& cells, int ranks, std::size_t bodies) : cells_(cells) {
  const auto grid = cheapest_grid(cells, ranks);
  if (!grid) throw no_grid(cells, ranks);
  grid_ = *grid;
  // Along the axis with most blocks, which share what the first one has less.
  const auto axis = std::ranges::max_element(grid_) - grid_.begin();
  if (grid_[axis] == 1) return;
  const std::int64_t blocks = grid_[axis];
  const std::int64_t layer = cells[(axis + 1) % 3] * cells[(axis + 2) % 3] * blocks / ranks;
  less_[axis] = std::min(cells_per_body * static_cast<std::int64_t>(bodies) / std::max(layer, std::int64_t{1}),
                         (cells[axis] - blocks) / (blocks - 1));
}

// Block i of p along n cells that begin at d is [⌊i (n + d) / p⌋, ⌊(i + 1) (n + d) / p⌋): extents differ by at most
// one, but for the first, which is shorter by d and has a cell if d ≤ (n − p) / (p − 1).
Box BlockPartition::block(int rank) const {
  const std::array<std::int64_t, 3> place = {rank / (grid_[1] * grid_[2]), rank / grid_[2] % grid_[1], rank % grid_[2]};
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t end = cells_[axis] + less_[axis];
    box.low[axis] = std::max(std::int64_t{0}, place[axis] * end / grid_[axis] - less_[axis]);
    box.high[axis] = (place[axis] + 1) * end / grid_[axis] - less_[axis];
  }
  return box;
}

// The block of cell c, counted from d, is the largest i with ⌊i (n + d) / p⌋ ≤ c: i ≤ ((c + 1) p − 1) / (n + d).
int BlockPartition::place(int axis, std::int64_t index) const {
  return static_cast<int>(((index + less_[axis] + 1) * grid_[axis] - 1) / (cells_[axis] + less_[axis]));
}

int BlockPartition::owner(const Cell& cell) const {
  int rank = 0;
  for (int axis = 0; axis < 3; ++axis) rank = rank * grid_[axis] + place(axis, cell[axis]);
  return rank;
}

}  // namespace copepod::fluid
