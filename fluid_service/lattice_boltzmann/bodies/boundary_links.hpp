#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"

namespace copepod::fluid {

/// A fluid cell next to a body, with its links into that body.
struct BoundaryCell {
  Site site;
  Cell position{};                 ///< domain cell, of this rank
  std::uint32_t directions = 0;    ///< bit α set: x_f + e_α is covered by the body
  std::uint32_t second_cells = 0;  ///< bit α set: x_f − e_α is fluid
  bool border = false;             ///< touches another rank's populations (HaloExchange::interior)
};

/// Links of each body: lists of boundary cells, kept up to date around cells that change hands.
class BoundaryLinks {
 public:
  BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, const Box& interior);

  /// Follows an update of the map: only cells next to a changed one can differ.
  void update();
  /// Sorted by cell.
  [[nodiscard]] std::span<const BoundaryCell> of_body(std::size_t body) const { return cells_[body]; }

 private:
  void look_at(const Cell& cell, std::int32_t changed_body);
  void set(std::int32_t body, const Cell& cell, std::uint32_t directions, std::uint32_t second_cells);

  const BodyMap& map_;
  const PopulationLayout& layout_;
  Box interior_;
  std::vector<std::vector<BoundaryCell>> cells_;
};

inline BoundaryLinks::BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, const Box& interior)
    : map_(map), layout_(layout), interior_(interior), cells_(map.bodies().size()) {}

inline void BoundaryLinks::update() {
  for (const BodyMap::ChangedCell& c : map_.changed()) {
    const std::int64_t index = layout_.cell(c.cell);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      const auto& e = d3q19::e[alpha];
      const Cell cell = {c.cell[0] + e[0], c.cell[1] + e[1], c.cell[2] + e[2]};
      if (!layout_.block().contains(cell)) continue;
      // A neighbour inside the same body has no link into it, or has changed itself.
      if (alpha > 0 && map_.owner(index + layout_.neighbour(alpha)) == c.body + 1) continue;
      look_at(cell, c.body);
    }
  }
}

/// Links of one cell into every body beside it, and into the one that changed there.
inline void BoundaryLinks::look_at(const Cell& cell, std::int32_t changed_body) {
  const Site site = layout_.site(cell);
  const std::int64_t index = site.index;
  const bool solid = map_.owner(index) > BodyMap::fluid;
  std::uint32_t left = 0;  // directions into bodies that have not been looked at
  std::uint32_t second_cells = 0;
  for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
    const auto& e = d3q19::e[alpha];
    if (map_.owner(index + layout_.neighbour(alpha)) > BodyMap::fluid)
      left |= 1U << alpha;
    else if (site.faces == 0 || map_.domain().canonical({cell[0] + e[0], cell[1] + e[1], cell[2] + e[2]}))
      second_cells |= 1U << d3q19::opposite(alpha);
  }
  const auto directions_into = [&](std::int32_t body) {
    std::uint32_t directions = 0;
    for (int alpha = 1; alpha < d3q19::directions; ++alpha)
      if (map_.owner(index + layout_.neighbour(alpha)) == body + 1) directions |= 1U << alpha;
    return directions;
  };
  set(changed_body, cell, solid ? 0 : directions_into(changed_body), second_cells);
  for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
    if (((left >> alpha) & 1U) == 0) continue;
    const std::int32_t body = map_.owner(index + layout_.neighbour(alpha)) - 1;
    const std::uint32_t directions = directions_into(body);
    left &= ~directions;
    if (body != changed_body) set(body, cell, solid ? 0 : directions, second_cells);
  }
}

inline void BoundaryLinks::set(std::int32_t body, const Cell& cell, std::uint32_t directions,
                               std::uint32_t second_cells) {
  std::vector<BoundaryCell>& cells = cells_[static_cast<std::size_t>(body)];
  const Site site = layout_.site(cell);
  const auto place = std::lower_bound(cells.begin(), cells.end(), site.index,
                                      [](const BoundaryCell& b, std::int64_t i) { return b.site.index < i; });
  const bool present = place != cells.end() && place->site.index == site.index;
  if (directions == 0) {
    if (present) cells.erase(place);
  } else if (present) {
    place->directions = directions;
    place->second_cells = second_cells;
  } else {
    const Cell& low = layout_.block().low;
    const Cell local = {cell[0] - low[0], cell[1] - low[1], cell[2] - low[2]};
    cells.insert(place, {site, cell, directions, second_cells, !interior_.contains(local)});
  }
}

}  // namespace copepod::fluid
