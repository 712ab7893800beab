#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

namespace copepod::fluid {

/// Links of each body, kept up to date around cells that change hands. Links change rarely, and the bulk update leaves
/// the populations of boundary cells in the cache: they are collected then and there, so that the next exchange need
/// not fetch each from a cache line of its own. One step:
///   update -> fetch (what is new) -> momentum exchange -> put_back, bulk update, collect (strip by strip)
template <class T>
class BoundaryLinks {
 public:
  /// @param second_cells  the link formula reads f̃_ᾱ(x_f) and the momentum of x_f
  BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, bool second_cells);

  /// Follows an update of the map: only cells next to a changed one can differ.
  void update();
  /// Reads the populations of cells that have become boundary cells, or have other links, since the last bulk update.
  void fetch(const T* populations, Placement placement);
  /// Lets the next fetch read all: the populations are not those of the last collect.
  void forget_populations();

  /// Gives a cell of this rank links into a body, or takes them from it (no directions).
  void set(std::int32_t body, const Cell& cell, std::uint32_t directions, std::uint32_t second_cells);

  [[nodiscard]] const BodySurface& of_body(std::size_t body) const { return surfaces_[body]; }
  [[nodiscard]] LinkPopulations<T>& populations() { return links_; }

  /// Puts f_ᾱ of the boundary cells of `region` (indices from the block's low corner) where the bulk update reads it.
  /// @param placement  before the update
  void put_back(T* populations, Placement placement, const Box& region) const;
  /// Reads f̃_α of these cells after their bulk update.
  /// @param placement  after the update
  void collect(const T* populations, Placement placement, const Box& region);

 private:
  struct CellInRow {
    std::int32_t z = 0;  ///< from the block's low corner
    std::uint32_t body = 0;
    std::uint32_t directions = 0;
    SurfacePlace place;
  };
  struct LinkInRow {
    std::int32_t z = 0;          ///< of x_f
    std::uint32_t link = 0;      ///< its place in LinkPopulations
    std::uint8_t direction = 0;  ///< α
    Faces faces = 0;             ///< that x_f lies on
  };
  /// What the bulk update of a row has to do with bodies. A cell beside two bodies is there twice.
  struct Row {
    std::vector<CellInRow> cells;
    std::vector<LinkInRow> links;  ///< those of a cell follow each other
  };

  void look_at(const Cell& cell, std::int32_t changed_body);
  [[nodiscard]] std::size_t row(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(x * layout_.block().extent(1) + y);
  }
  /// Where f̃_α is after the update: before it, the update reads f_ᾱ there.
  [[nodiscard]] std::int64_t location(std::int64_t row_start, const LinkInRow& link, Placement after) const {
    return row_start + link.z + layout_.locations(link.faces, after)[link.direction];
  }
  [[nodiscard]] Moments<double> moments_at(const T* populations, Placement placement, const Site& site) const;
  void read(const T* populations, Placement placement, std::uint32_t body, const SurfacePlace& place);

  const BodyMap& map_;
  const PopulationLayout& layout_;
  bool second_cells_;
  std::vector<BodySurface> surfaces_;
  LinkPopulations<T> links_;
  std::vector<Row> rows_;  ///< shape (x, y) of the block
  struct NewCell {
    std::uint32_t body = 0;
    SurfacePlace place;
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
  const auto number = static_cast<std::uint32_t>(body);
  const Cell& low = layout_.block().low;
  const std::array local = {static_cast<std::int32_t>(cell[0] - low[0]), static_cast<std::int32_t>(cell[1] - low[1]),
                            static_cast<std::int32_t>(cell[2] - low[2])};
  BodySurface& surface = surfaces_[number];
  Row& in_row = rows_[row(local[0], local[1])];
  const auto known =
      std::ranges::find_if(in_row.cells, [&](const CellInRow& c) { return c.z == local[2] && c.body == number; });
  if (known != in_row.cells.end()) {
    const CellGroup& group = surface.groups[known->place.group];
    if (known->directions == directions) {
      surface.groups[known->place.group].second_cells[known->place.lane] = second_cells;
      return;
    }
    const std::size_t first = group.first_link + known->place.lane;
    for (std::size_t j = 0; j < group.links; ++j) {
      links_.crossing[first + j * surface_lanes] = T(0);
      if (second_cells_) links_.inward[first + j * surface_lanes] = T(0);
    }
    const auto link = std::ranges::find(in_row.links, first, &LinkInRow::link);
    in_row.links.erase(link, link + group.links);
    surface.remove(known->place);
    *known = in_row.cells.back();
    in_row.cells.pop_back();
  }
  if (directions == 0) return;
  std::size_t links = links_.crossing.size();
  const SurfacePlace place = surface.add(local, directions, second_cells, links);
  links_.crossing.resize(links);
  if (second_cells_) {
    links_.inward.resize(links);
    surface.momentum.resize(surface.groups.size());
  }
  const Faces faces = layout_.site(cell).faces;
  in_row.cells.push_back({local[2], number, directions, place});
  std::uint32_t link = surface.groups[place.group].first_link + place.lane;
  for (std::uint32_t bits = directions; bits != 0; bits &= bits - 1, link += surface_lanes)
    in_row.links.push_back({local[2], link, static_cast<std::uint8_t>(std::countr_zero(bits)), faces});
  new_cells_.push_back({number, place});
}

/// The same bits for a cell and its mirror image.
template <class T>
inline Moments<double> BoundaryLinks<T>::moments_at(const T* populations, Placement placement, const Site& site) const {
  struct InPlace {
    const T* cell;
    const PopulationLayout::Locations& from;
    double operator[](std::size_t alpha) const { return static_cast<double>(cell[from[alpha]]); }
  };
  return moments(InPlace{populations + site.index, layout_.locations(site.faces, placement)});
}

template <class T>
void BoundaryLinks<T>::read(const T* populations, Placement placement, std::uint32_t body, const SurfacePlace& place) {
  BodySurface& surface = surfaces_[body];
  CellGroup& group = surface.groups[place.group];
  const Site site = layout_.site(group.cell[0][place.lane], group.cell[1][place.lane], group.cell[2][place.lane]);
  const Moments<double> m = moments_at(populations, placement, site);
  group.excess_density[place.lane] = m.excess_density;
  std::size_t link = group.first_link + place.lane;
  for (std::uint32_t bits = group.directions[place.lane]; bits != 0; bits &= bits - 1, link += surface_lanes) {
    const int alpha = std::countr_zero(bits);
    links_.crossing[link] = populations[layout_.location(site, alpha, placement)];
    if (second_cells_) links_.inward[link] = populations[layout_.location(site, d3q19::opposite(alpha), placement)];
  }
  if (!second_cells_) return;
  for (std::size_t axis = 0; axis < 3; ++axis) surface.momentum[place.group][axis][place.lane] = m.momentum[axis];
}

template <class T>
void BoundaryLinks<T>::fetch(const T* populations, Placement placement) {
  constexpr std::size_t ahead = 4;  // every population is a cache line of its own, which takes its time
  for (std::size_t i = 0; i < new_cells_.size(); ++i) {
    if (i + ahead < new_cells_.size()) {
      const auto& [body, place] = new_cells_[i + ahead];
      const auto& cell = surfaces_[body].groups[place.group].cell;
      const Site site = layout_.site(cell[0][place.lane], cell[1][place.lane], cell[2][place.lane]);
      for (int alpha = 0; alpha < d3q19::directions; ++alpha)
        __builtin_prefetch(populations + layout_.location(site, alpha, placement));
    }
    read(populations, placement, new_cells_[i].body, new_cells_[i].place);  // nothing where the lane is free again
  }
  new_cells_.clear();
}

template <class T>
void BoundaryLinks<T>::forget_populations() {
  new_cells_.clear();
  for (const Row& row : rows_)
    for (const CellInRow& cell : row.cells) new_cells_.push_back({cell.body, cell.place});
}

template <class T>
void BoundaryLinks<T>::put_back(T* populations, Placement placement, const Box& region) const {
  const T* const returning = links_.crossing.data();
  for (std::int64_t x = region.low[0]; x < region.high[0]; ++x)
    for (std::int64_t y = region.low[1]; y < region.high[1]; ++y) {
      const std::int64_t start = layout_.cell(x, y, 0);
      for (const LinkInRow& link : rows_[row(x, y)].links)
        if (region.contains_along(2, link.z))
          populations[location(start, link, other(placement))] = returning[link.link];
    }
}

template <class T>
void BoundaryLinks<T>::collect(const T* populations, Placement placement, const Box& region) {
  T* const crossing = links_.crossing.data();
  for (std::int64_t x = region.low[0]; x < region.high[0]; ++x)
    for (std::int64_t y = region.low[1]; y < region.high[1]; ++y) {
      const Row& in_row = rows_[row(x, y)];
      const std::int64_t start = layout_.cell(x, y, 0);
      for (const LinkInRow& link : in_row.links) {
        if (!region.contains_along(2, link.z)) continue;
        crossing[link.link] = populations[location(start, link, placement)];
        if (second_cells_)
          links_.inward[link.link] =
              populations[start + link.z +
                          layout_.locations(link.faces,
                                            placement)[static_cast<std::size_t>(d3q19::opposite(link.direction))]];
      }
      for (const CellInRow& cell : in_row.cells) {
        if (!region.contains_along(2, cell.z)) continue;
        const Moments<double> m = moments_at(populations, placement, layout_.site(x, y, cell.z));
        BodySurface& surface = surfaces_[cell.body];
        surface.groups[cell.place.group].excess_density[cell.place.lane] = m.excess_density;
        if (!second_cells_) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          surface.momentum[cell.place.group][axis][cell.place.lane] = m.momentum[axis];
      }
    }
}

}  // namespace copepod::fluid
