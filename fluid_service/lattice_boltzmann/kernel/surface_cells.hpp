#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace copepod::fluid {

/// Boundary cells are computed eight at a time, one per lane of a SIMD register.
inline constexpr std::size_t surface_lanes = 8;

template <class U>
using Lanes = std::array<U, surface_lanes>;

/// Eight fluid cells next to a body that have equally many links into it: one format for any instruction set [sliced
/// ELLPACK: Monakov, Lokhmotov, Avetisyan 2010].
struct CellGroup {
  std::array<Lanes<std::int32_t>, 3> cell{};  ///< place in the rank's block, from its low corner
  Lanes<std::uint32_t> directions{};          ///< bit α set: x_f + e_α is covered by the body; none: the lane is free
  Lanes<std::uint32_t> second_cells{};        ///< bit α set: x_f − e_α is fluid
  Lanes<double> excess_density{};
  std::uint32_t first_link = 0;  ///< link j of lane l has place first_link + 8 j + l in LinkPopulations
  std::uint32_t links = 0;       ///< of each cell, by ascending α
  std::uint32_t used = 0;        ///< lanes
};

/// A cell in BodySurface.
struct SurfacePlace {
  std::uint32_t group = 0;
  std::uint32_t lane = 0;
};

/// Boundary cells of one body on this rank.
struct BodySurface {
  std::vector<CellGroup> groups;
  std::vector<std::array<Lanes<double>, 3>> momentum;  ///< by group, if a link formula uses second cells

  /// @param links  places of links in use; a new group takes the next ones
  SurfacePlace add(const std::array<std::int32_t, 3>& cell, std::uint32_t directions, std::uint32_t second_cells,
                   std::size_t& links);
  void remove(const SurfacePlace& place);

 private:
  std::array<std::uint32_t, 19> last_{};  ///< by number of links: the group to which a cell was added last
};

/// By link, of all bodies on this rank; 0 in free lanes.
template <class T>
struct LinkPopulations {
  /// f̃_α(x_f) from the bulk update to the exchange, which replaces it by f_ᾱ(x_f) for the next update.
  std::vector<T> crossing;
  std::vector<T> inward;  ///< f̃_ᾱ(x_f), if a link formula uses second cells
};

inline SurfacePlace BodySurface::add(const std::array<std::int32_t, 3>& cell, std::uint32_t directions,
                                     std::uint32_t second_cells, std::size_t& links) {
  const auto links_of_cell = static_cast<std::uint32_t>(std::popcount(directions));
  const auto has_room = [&](const CellGroup& g) { return g.links == links_of_cell && g.used < surface_lanes; };
  std::uint32_t& last = last_[links_of_cell];
  if (last >= groups.size() || !has_room(groups[last])) {
    last = static_cast<std::uint32_t>(std::ranges::find_if(groups, has_room) - groups.begin());
    if (last == groups.size()) {
      CellGroup& added = groups.emplace_back();
      added.first_link = static_cast<std::uint32_t>(links);
      added.links = links_of_cell;
      links += links_of_cell * surface_lanes;
    }
  }
  CellGroup& group = groups[last];
  const auto lane = static_cast<std::uint32_t>(std::ranges::find(group.directions, 0U) - group.directions.begin());
  for (std::size_t axis = 0; axis < 3; ++axis) group.cell[axis][lane] = cell[axis];
  group.directions[lane] = directions;
  group.second_cells[lane] = second_cells;
  ++group.used;
  return {last, lane};
}

inline void BodySurface::remove(const SurfacePlace& place) {
  CellGroup& group = groups[place.group];
  group.directions[place.lane] = 0;
  group.excess_density[place.lane] = 0.0;
  --group.used;
  if (momentum.empty()) return;
  for (Lanes<double>& component : momentum[place.group]) component[place.lane] = 0.0;
}

}  // namespace copepod::fluid
