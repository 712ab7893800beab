#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "lattice_boltzmann/lattice/huge_array.hpp"

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
  Lanes<std::uint32_t> first_link{};          ///< of each cell: its links, by ascending α, follow each other there
  Lanes<std::uint32_t> moments{};             ///< place of each cell's moments
  std::uint32_t links = 0;                    ///< of each cell
  std::uint32_t used = 0;                     ///< lanes

  void set_free(std::size_t lane) {
    directions[lane] = first_link[lane] = moments[lane] = 0;
    --used;
  }
};

/// A row's part of the arrays by link and by cell, which are in the order of z there, with room for more.
struct BoundaryRow {
  std::uint32_t first_link = 0;
  std::uint32_t links = 0;
  std::uint32_t room_for_links = 0;
  std::uint32_t first_cell = 0;
  std::uint32_t cells = 0;
  std::uint32_t room_for_cells = 0;
};

/// A link of a row: 2⁵ z + α, z of x_f from the block's low corner.
using LinkInRow = std::uint32_t;
inline constexpr int direction_bits = 5;
constexpr std::int64_t z_of(LinkInRow link) { return link >> direction_bits; }
constexpr std::uint32_t direction_of(LinkInRow link) { return link % (1U << direction_bits); }

/// What the momentum exchange reads and writes of the boundary cells of a rank, in the order of rows. It starts with
/// zeros, which are those of free lanes. With formulas that use second cells, links have the values inward and behind
/// too, and cells their momentum.
template <class T>
struct BoundaryValues {
  static constexpr std::size_t crossing = 0;  ///< f̃_α(x_f) from an update to the exchange; then f_ᾱ(x_f) for the next
  static constexpr std::size_t inward = 1;  ///< f̃_ᾱ(x_f)
  static constexpr std::size_t behind = 2;  ///< f̃_α(x_f − e_α)
  static constexpr std::size_t excess_density = 0;
  static constexpr std::size_t momentum = 1;  ///< x; then y, z

  static constexpr std::size_t per_link(bool second_cells) { return second_cells ? 3 : 1; }
  static constexpr std::size_t per_cell(bool second_cells) { return second_cells ? 4 : 1; }

  HugeVector<T> by_link;       ///< per_link values each
  HugeVector<double> by_cell;  ///< per_cell values each
};

/// Boundary cells as the bulk update goes through them: BoundaryValues, and where they are.
template <class T>
struct RowsBesideBodies {
  const BoundaryRow* rows = nullptr;  ///< shape (x, y) of the block
  const LinkInRow* links = nullptr;
  const std::int32_t* z = nullptr;  ///< by cell, from the block's low corner
  T* by_link = nullptr;
  double* by_cell = nullptr;
  bool second_cells = false;  ///< whether a link formula uses them
};

/// A cell in BodySurface.
struct SurfacePlace {
  std::uint32_t group = 0;
  std::uint32_t lane = 0;
};

/// Boundary cells of one body on this rank.
struct BodySurface {
  std::vector<CellGroup> groups;
  std::vector<double> wall_distances;  ///< of an obstacle, as BodyInBlock has them; empty when cells were added

  SurfacePlace add(const std::array<std::int32_t, 3>& cell, std::uint32_t directions, std::uint32_t second_cells);
  void remove(const SurfacePlace& place);
  /// Adds the cell at a place of another group; on return `place` is the one here.
  void move_here(const CellGroup& group, SurfacePlace& place);

 private:
  std::array<std::uint32_t, 19> last_{};  ///< by number of links: the group to which a cell was added last
};

inline SurfacePlace BodySurface::add(const std::array<std::int32_t, 3>& cell, std::uint32_t directions,
                                     std::uint32_t second_cells) {
  wall_distances.clear();
  const auto links = static_cast<std::uint32_t>(std::popcount(directions));
  const auto has_room = [&](const CellGroup& g) { return g.links == links && g.used < surface_lanes; };
  std::uint32_t& last = last_[links];
  if (last >= groups.size() || !has_room(groups[last])) {
    last = static_cast<std::uint32_t>(std::ranges::find_if(groups, has_room) - groups.begin());
    if (last == groups.size()) groups.emplace_back().links = links;
  }
  CellGroup& group = groups[last];
  const auto lane = static_cast<std::uint32_t>(std::ranges::find(group.directions, 0U) - group.directions.begin());
  for (std::size_t axis = 0; axis < 3; ++axis) group.cell[axis][lane] = cell[axis];
  group.directions[lane] = directions;
  group.second_cells[lane] = second_cells;
  ++group.used;
  return {last, lane};
}

inline void BodySurface::move_here(const CellGroup& group, SurfacePlace& place) {
  const std::uint32_t lane = place.lane;
  place = add({group.cell[0][lane], group.cell[1][lane], group.cell[2][lane]}, group.directions[lane],
              group.second_cells[lane]);
  CellGroup& here = groups[place.group];
  here.first_link[place.lane] = group.first_link[lane];
  here.moments[place.lane] = group.moments[lane];
}

inline void BodySurface::remove(const SurfacePlace& place) { groups[place.group].set_free(place.lane); }

}  // namespace copepod::fluid
