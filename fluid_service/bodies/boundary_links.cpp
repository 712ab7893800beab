#include "bodies/boundary_links.hpp"

#include <algorithm>

namespace copepod::fluid {

namespace {

bool overlap(const Box& a, const Box& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (a.low[axis] >= b.high[axis] || b.low[axis] >= a.high[axis]) return false;
  return true;
}

Box intersection(const Box& a, const Box& b) {
  Box result;
  for (int axis = 0; axis < 3; ++axis) {
    result.low[axis] = std::max(a.low[axis], b.low[axis]);
    result.high[axis] = std::min(a.high[axis], b.high[axis]);
  }
  return result;
}

}  // namespace

BoundaryLinks::BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, const Box& interior)
    : map_(map), layout_(layout), interior_(interior), cells_(map.bodies().size()) {}

void BoundaryLinks::rebuild_changed() {
  for (std::size_t body = 0; body < cells_.size(); ++body) {
    const std::vector<Box> reach = map_.reach(map_.bodies()[body]);
    const auto changed = [&](const Box& box) {
      return std::any_of(map_.changed().begin(), map_.changed().end(),
                         [&](const Box& c) { return overlap(box, c); });
    };
    if (std::any_of(reach.begin(), reach.end(), changed)) rebuild(body);
  }
}

void BoundaryLinks::rebuild(std::size_t body) {
  std::vector<BoundaryCell>& cells = cells_[body];
  cells.clear();
  const auto owner = static_cast<std::int32_t>(body) + 1;
  const Box& block = layout_.block();
  for (const Box& reach : map_.reach(map_.bodies()[body])) {
    const Box box = intersection(reach, block);
    for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
      for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
        for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) {
          const std::int64_t cell = layout_.cell(Cell{x, y, z});
          if (map_.owner(cell) > BodyMap::fluid) continue;
          std::uint32_t directions = 0;
          for (int alpha = 1; alpha < d3q19::directions; ++alpha)
            if (map_.owner(cell + layout_.neighbour(alpha)) == owner) directions |= 1U << alpha;
          if (directions == 0) continue;
          const Cell local = {x - block.low[0], y - block.low[1], z - block.low[2]};
          cells.push_back({cell, {x, y, z}, directions, !interior_.contains(local)});
        }
  }
  // Boxes of several images may overlap: each cell counts once.
  std::sort(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.cell < b.cell; });
  cells.erase(
      std::unique(cells.begin(), cells.end(), [](const auto& a, const auto& b) { return a.cell == b.cell; }),
      cells.end());
}

}  // namespace copepod::fluid
