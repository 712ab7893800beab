#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

namespace copepod::fluid {

/// A fluid cell next to a body, with its links into that body.
struct BoundaryCell {
  std::array<std::int32_t, 3> place{};  ///< in the rank's block, from its low corner
  std::uint32_t directions = 0;    ///< bit α set: x_f + e_α is covered by the body; none: no longer a boundary cell
  std::uint32_t second_cells = 0;  ///< bit α set: x_f − e_α is fluid
  std::uint32_t first_link = 0;    ///< its place in BodySurface; the cell's other links follow by ascending α
};

/// Boundary cells and links of one body on this rank, and the populations of these cells. Links into a body change
/// rarely, and the bulk update leaves these populations in the cache: BoundaryLinks::collect puts them here, side by
/// side, so that the next exchange need not fetch each from a cache line of its own.
template <class T>
struct BodySurface {
  std::vector<BoundaryCell> cells;     ///< in no order, with gaps (no directions)
  std::vector<double> excess_density;  ///< by cell
  /// By link: f̃_α(x_f) from the bulk update to the exchange, which replaces it by f_ᾱ(x_f) for the next update.
  std::vector<T> populations;
  std::vector<Eigen::Vector3d> momentum;  ///< by cell, if a formula uses second cells
  std::vector<T> inward;                  ///< by link, likewise: f̃_ᾱ(x_f)
  std::size_t gaps = 0;                   ///< links that no cell has any more
};

/// Links of each body, kept up to date around cells that change hands. One step:
///   update -> fetch (what is new) -> momentum exchange -> put_back, bulk update, collect (strip by strip)
template <class T>
class BoundaryLinks {
 public:
  /// @param second_cells  a formula reads f̃_ᾱ(x_f) and the momentum of x_f
  BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, bool second_cells);

  /// Follows an update of the map: only cells next to a changed one can differ.
  void update();
  /// Reads the populations of cells that have become boundary cells, or have other links, since the last bulk update.
  void fetch(const T* populations, Placement placement);
  /// Lets the next fetch read all: the populations are not those of the last collect.
  void forget_populations();

  [[nodiscard]] BodySurface<T>& of_body(std::size_t body) { return surfaces_[body]; }
  [[nodiscard]] const BodySurface<T>& of_body(std::size_t body) const { return surfaces_[body]; }

  /// Puts f_ᾱ of the boundary cells of `region` (indices from the block's low corner) where the bulk update reads it.
  /// @param placement  before the update
  void put_back(T* populations, Placement placement, const Box& region) const;
  /// Reads f̃_α of these cells after their bulk update. While it does, memory has nothing to do: it asks for what the
  /// region's next rows have to put back.
  /// @param rows_ahead  so far away are they, in the order (x, y)
  void collect(const T* populations, Placement placement, const Box& region, std::int64_t rows_ahead);

 private:
  /// A boundary cell as its row of the block knows it: what the bulk update needs of it.
  struct CellInRow {
    std::int32_t z = 0;  ///< from the block's low corner
    std::uint32_t body = 0;
    std::uint32_t cell = 0;  ///< its place in BodySurface
    std::uint32_t directions = 0;
    std::uint32_t first_link = 0;
  };

  void look_at(const Cell& cell, std::int32_t changed_body);
  void set(std::int32_t body, const Cell& cell, std::uint32_t directions, std::uint32_t second_cells);
  [[nodiscard]] std::vector<CellInRow>& row_of(const BoundaryCell& cell) {
    return rows_[row(cell.place[0], cell.place[1])];
  }
  [[nodiscard]] std::size_t row(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(x * layout_.block().extent(1) + y);
  }
  [[nodiscard]] Site site_of(const BoundaryCell& cell) const {
    return layout_.site(cell.place[0], cell.place[1], cell.place[2]);
  }
  void store(const T* populations, const Site& site, Placement placement, const CellInRow& cell);
  void prefetch(const T* populations, const Site& site, Placement placement, const CellInRow& cell) const;
  void close_gaps(std::size_t body);

  const BodyMap& map_;
  const PopulationLayout& layout_;
  bool second_cells_;
  std::vector<BodySurface<T>> surfaces_;
  std::vector<std::vector<CellInRow>> rows_;  ///< shape (x, y) of the block; a cell beside two bodies is there twice
  struct NewCell {
    std::uint32_t body = 0;
    std::uint32_t cell = 0;
  };
  std::vector<NewCell> new_cells_;  ///< since the last fetch
};

template <class T>
BoundaryLinks<T>::BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, bool second_cells)
    : map_(map),
      layout_(layout),
      second_cells_(second_cells),
      surfaces_(map.bodies().size()),
      rows_(surfaces_.empty() ? 0 : static_cast<std::size_t>(layout.block().extent(0) * layout.block().extent(1))) {}

template <class T>
void BoundaryLinks<T>::update() {
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
template <class T>
void BoundaryLinks<T>::look_at(const Cell& cell, std::int32_t changed_body) {
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

template <class T>
void BoundaryLinks<T>::set(std::int32_t body, const Cell& cell, std::uint32_t directions, std::uint32_t second_cells) {
  BodySurface<T>& surface = surfaces_[static_cast<std::size_t>(body)];
  const auto place = static_cast<std::uint32_t>(surface.cells.size());
  const auto link = static_cast<std::uint32_t>(surface.populations.size());
  BoundaryCell added{{}, directions, second_cells, link};
  for (std::size_t axis = 0; axis < 3; ++axis)
    added.place[axis] = static_cast<std::int32_t>(cell[axis] - layout_.block().low[axis]);
  std::vector<CellInRow>& row = row_of(added);
  const CellInRow in_row{added.place[2], static_cast<std::uint32_t>(body), place, directions, link};
  const auto known =
      std::ranges::find_if(row, [&](const CellInRow& c) { return c.z == in_row.z && c.body == in_row.body; });
  if (known != row.end()) {
    BoundaryCell& before = surface.cells[known->cell];
    if (before.directions == directions) {
      before.second_cells = second_cells;
      return;
    }
    surface.gaps += static_cast<std::size_t>(std::popcount(before.directions));
    before.directions = 0;
    *known = row.back();
    row.pop_back();
  }
  if (directions == 0) return;
  surface.cells.push_back(added);
  surface.excess_density.emplace_back();
  surface.populations.resize(link + static_cast<std::size_t>(std::popcount(directions)));
  if (second_cells_) {
    surface.momentum.emplace_back();
    surface.inward.resize(surface.populations.size());
  }
  row.push_back(in_row);
  new_cells_.push_back({in_row.body, place});
}

template <class T>
void BoundaryLinks<T>::store(const T* populations, const Site& site, Placement placement, const CellInRow& cell) {
  BodySurface<T>& surface = surfaces_[cell.body];
  const PopulationLayout::Locations& from = layout_.locations(site.faces, placement);
  const T* const f = populations + site.index;
  T* leaving = surface.populations.data() + cell.first_link;
  for (std::uint32_t bits = cell.directions; bits != 0; bits &= bits - 1)
    *leaving++ = f[from[static_cast<std::size_t>(std::countr_zero(bits))]];
  const Moments<double> m =
      moments(layout_.gather(populations, site, placement));  // of the same bits for a mirror image
  surface.excess_density[cell.cell] = m.excess_density;
  if (!second_cells_) return;
  surface.momentum[cell.cell] = m.momentum_vector();
  T* inward = surface.inward.data() + cell.first_link;
  for (std::uint32_t bits = cell.directions; bits != 0; bits &= bits - 1)
    *inward++ = f[from[static_cast<std::size_t>(d3q19::opposite(std::countr_zero(bits)))]];
}

template <class T>
void BoundaryLinks<T>::fetch(const T* populations, Placement placement) {
  constexpr std::size_t ahead = 4;  // every population is a cache line of its own, which takes its time
  for (std::size_t i = 0; i < new_cells_.size(); ++i) {
    if (i + ahead < new_cells_.size()) {
      const auto [body, cell] = new_cells_[i + ahead];
      for (int alpha = 0; alpha < d3q19::directions; ++alpha)
        __builtin_prefetch(populations + layout_.location(site_of(surfaces_[body].cells[cell]), alpha, placement));
    }
    const auto [body, place] = new_cells_[i];
    const BoundaryCell& cell = surfaces_[body].cells[place];
    store(populations, site_of(cell), placement, {cell.place[2], body, place, cell.directions, cell.first_link});
  }
  for (const NewCell& added : new_cells_) close_gaps(added.body);
  new_cells_.clear();
}

template <class T>
void BoundaryLinks<T>::forget_populations() {
  new_cells_.clear();
  for (std::uint32_t body = 0; body < surfaces_.size(); ++body)
    for (std::uint32_t cell = 0; cell < surfaces_[body].cells.size(); ++cell) new_cells_.push_back({body, cell});
}

/// Moves the cells of a body together when a quarter of its links are gaps.
template <class T>
void BoundaryLinks<T>::close_gaps(std::size_t body) {
  BodySurface<T>& surface = surfaces_[body];
  if (4 * surface.gaps < surface.populations.size()) return;
  std::uint32_t place = 0;
  std::uint32_t link = 0;
  for (std::uint32_t from = 0; from < surface.cells.size(); ++from) {
    BoundaryCell cell = surface.cells[from];
    if (cell.directions == 0) continue;
    const auto links = static_cast<std::uint32_t>(std::popcount(cell.directions));
    for (std::uint32_t i = 0; i < links; ++i) {
      surface.populations[link + i] = surface.populations[cell.first_link + i];
      if (second_cells_) surface.inward[link + i] = surface.inward[cell.first_link + i];
    }
    cell.first_link = link;
    surface.cells[place] = cell;
    surface.excess_density[place] = surface.excess_density[from];
    if (second_cells_) surface.momentum[place] = surface.momentum[from];
    auto& row = row_of(cell);
    const auto known = std::ranges::find_if(row, [&](const CellInRow& c) { return c.body == body && c.cell == from; });
    known->cell = place++;
    known->first_link = link;
    link += links;
  }
  surface.cells.resize(place);
  surface.excess_density.resize(place);
  surface.populations.resize(link);
  if (second_cells_) {
    surface.momentum.resize(place);
    surface.inward.resize(link);
  }
  surface.gaps = 0;
}

template <class T>
void BoundaryLinks<T>::put_back(T* populations, Placement placement, const Box& region) const {
  for (std::int64_t x = region.low[0]; x < region.high[0]; ++x)
    for (std::int64_t y = region.low[1]; y < region.high[1]; ++y)
      for (const CellInRow& cell : rows_[row(x, y)]) {
        if (!region.contains_along(2, cell.z)) continue;
        const Site site = layout_.site(x, y, cell.z);
        const T* returning = surfaces_[cell.body].populations.data() + cell.first_link;
        for (std::uint32_t bits = cell.directions; bits != 0; bits &= bits - 1)  // what leaves x_f + e_α towards x_f
          populations[layout_.entry(site, d3q19::opposite(std::countr_zero(bits)), placement)] = *returning++;
      }
}

template <class T>
void BoundaryLinks<T>::prefetch(const T* populations, const Site& site, Placement placement,
                                const CellInRow& cell) const {
  const BodySurface<T>& surface = surfaces_[cell.body];
  __builtin_prefetch(surface.populations.data() + cell.first_link, 1);
  __builtin_prefetch(surface.excess_density.data() + cell.cell, 1);
  for (std::uint32_t bits = cell.directions; bits != 0; bits &= bits - 1)
    __builtin_prefetch(populations + layout_.entry(site, d3q19::opposite(std::countr_zero(bits)), placement), 1);
}

template <class T>
void BoundaryLinks<T>::collect(const T* populations, Placement placement, const Box& region, std::int64_t rows_ahead) {
  const auto ny = layout_.block().extent(1);
  for (std::int64_t x = region.low[0]; x < region.high[0]; ++x)
    for (std::int64_t y = region.low[1]; y < region.high[1]; ++y) {
      const std::size_t here = row(x, y);
      const std::size_t ahead = std::min(here + static_cast<std::size_t>(rows_ahead), rows_.size() - 1);
      const auto next = static_cast<std::int64_t>(ahead);
      auto asked = rows_[ahead].begin();
      const auto ask = [&] {
        prefetch(populations, layout_.site(next / ny, next % ny, asked->z), other(placement), *asked);
        ++asked;
      };
      for (const CellInRow& cell : rows_[here]) {
        if (asked != rows_[ahead].end()) ask();
        if (region.contains_along(2, cell.z)) store(populations, layout_.site(x, y, cell.z), placement, cell);
      }
      while (asked != rows_[ahead].end()) ask();
    }
}

}  // namespace copepod::fluid
