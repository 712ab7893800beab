#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"
#include "lattice_boltzmann/kernel/stream_collide.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

namespace copepod::fluid {

/// Links of each body, kept up to date around cells that change hands, and what the momentum exchange reads of their
/// cells. The bulk update puts back what returns along links and collects what leaves, while the populations are in the
/// cache (stream_collide.hpp). Links change rarely: between two updates only those that are new are fetched, and what
/// second cells send. One step:
///   update -> fetch -> momentum exchange -> bulk update, with rows()
template <class T>
class BoundaryLinks {
 public:
  /// @param second_cells  the link formula reads f̃_ᾱ(x_f) and the momentum of x_f
  BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, bool second_cells);

  /// Follows an update of the map: only cells next to a changed one can differ.
  void update();
  /// Reads the populations of cells that have become boundary cells, or have other links, since the last bulk update.
  /// Second cells are read anew.
  void fetch(const T* populations, Placement placement);
  /// Lets the next fetch read all: the populations are not those of the last collect.
  void forget_populations();

  /// Gives a cell of this rank links into a body, or takes them from it (no directions).
  void set(std::int32_t body, const Cell& cell, std::uint32_t directions, std::uint32_t second_cells);

  [[nodiscard]] const BodySurface& of_body(std::size_t body) const { return surfaces_[body]; }
  [[nodiscard]] BodySurface& of_body(std::size_t body) { return surfaces_[body]; }
  [[nodiscard]] BoundaryValues<T>& values() { return arrays_.values; }

  /// For the bulk update, which puts f_ᾱ of boundary cells where it reads it, and collects f̃_α and moments.
  [[nodiscard]] RowsBesideBodies<T> rows();

 private:
  /// A boundary cell, which is there twice if it lies beside two bodies.
  struct CellInRow {
    std::uint32_t body = 0;
    SurfacePlace place;
  };
  struct Arrays {
    BoundaryValues<T> values;
    HugeVector<LinkInRow> links;
    HugeVector<std::int32_t> z;  ///< by cell
    HugeVector<CellInRow> cells;
  };
  void look_at(const Cell& cell);
  [[nodiscard]] std::size_t row(std::int64_t x, std::int64_t y) const {
    return static_cast<std::size_t>(x * layout_.block().extent(1) + y);
  }
  [[nodiscard]] CellGroup& group_of(const CellInRow& cell) { return surfaces_[cell.body].groups[cell.place.group]; }
  void add(BoundaryRow& row, const Cell& local, std::uint32_t body, std::uint32_t directions,
           std::uint32_t second_cells);
  void remove(BoundaryRow& row, std::uint32_t cell);
  void move(BoundaryRow& row, std::uint32_t cell, std::int32_t cells, std::uint32_t link, std::int32_t links);
  void append(BoundaryRow& row, const Arrays& from, Arrays& to, std::uint32_t links);
  void reserve(std::size_t cells);
  void put_in_order();
  /// visit(array of `from`, array of `to`, values per link or cell) for the arrays by link, and by cell.
  template <class Visit>
  void each_by_link(const Arrays& from, Arrays& to, const Visit& visit) const {
    visit(from.links, to.links, std::size_t{1});
    visit(from.values.by_link, to.values.by_link, BoundaryValues<T>::per_link(second_cells_));
  }
  template <class Visit>
  void each_by_cell(const Arrays& from, Arrays& to, const Visit& visit) const {
    visit(from.z, to.z, std::size_t{1});
    visit(from.cells, to.cells, std::size_t{1});
    visit(from.values.by_cell, to.values.by_cell, BoundaryValues<T>::per_cell(second_cells_));
  }
  /// Arrays of no row.
  [[nodiscard]] Arrays empty_arrays() const {
    Arrays arrays;
    each_by_link(arrays, arrays, [](const auto&, auto& array, std::size_t n) { array.resize(n * d3q19::directions); });
    each_by_cell(arrays, arrays, [](const auto&, auto& array, std::size_t n) { array.resize(n); });
    return arrays;
  }
  [[nodiscard]] T* values_of_link(std::uint32_t link) {
    return arrays_.values.by_link.data() + BoundaryValues<T>::per_link(second_cells_) * link;
  }

  [[nodiscard]] Moments<double> moments_at(const T* populations, Placement placement, const Site& site) const;
  void read(const T* populations, Placement placement, std::uint32_t body, const SurfacePlace& place);
  void read_second_cells(const T* populations, Placement placement);

  const BodyMap& map_;
  const PopulationLayout& layout_;
  bool second_cells_;
  std::vector<BodySurface> surfaces_;
  std::vector<BoundaryRow> rows_;  ///< shape (x, y) of the block
  Arrays arrays_;
  std::size_t links_in_use_ = 0;
  std::vector<bool> looked_at_;       ///< by cell, during an update
  std::vector<CellInRow> new_cells_;  ///< since the last fetch
};

template <class T>
BoundaryLinks<T>::BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, bool second_cells)
    : map_(map),
      layout_(layout),
      second_cells_(second_cells),
      surfaces_(map.bodies().size()),
      rows_(surfaces_.empty() ? 0 : static_cast<std::size_t>(layout.block().extent(0) * layout.block().extent(1))) {
  arrays_ = empty_arrays();
}

template <class T>
void BoundaryLinks<T>::update() {
  if (arrays_.links.size() > links_in_use_ + links_in_use_ / 2 + 8 * rows_.size() && new_cells_.empty()) put_in_order();
  looked_at_.resize(layout_.cells());
  std::vector<std::array<std::int32_t, 3>> cells;  // from the block's low corner
  const Cell& low = layout_.block().low;
  for (const BodyMap::ChangedCell& c : map_.changed()) {
    const Cell at = c.cell();
    const std::int64_t index = layout_.cell(at);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      const auto& e = d3q19::e[alpha];
      const Cell cell = {at[0] + e[0], at[1] + e[1], at[2] + e[2]};
      if (!layout_.block().contains(cell)) continue;
      const auto neighbour = static_cast<std::size_t>(index + layout_.neighbour(alpha));
      // A neighbour inside the same body has no links, or has changed itself.
      if (alpha > 0 && map_.owner(static_cast<std::int64_t>(neighbour)) == c.body + 1) continue;
      if (looked_at_[neighbour]) continue;
      looked_at_[neighbour] = true;
      cells.push_back({static_cast<std::int32_t>(cell[0] - low[0]), static_cast<std::int32_t>(cell[1] - low[1]),
                       static_cast<std::int32_t>(cell[2] - low[2])});
    }
  }
  std::ranges::sort(cells);  // rows in their order grow at the end of the arrays, where there is room
  if (cells.size() > arrays_.cells.size()) reserve(cells.size());
  for (const auto& [x, y, z] : cells) {
    looked_at_[layout_.cell(x, y, z)] = false;
    look_at({low[0] + x, low[1] + y, low[2] + z});
  }
}

/// Links of one cell into every body beside it.
template <class T>
void BoundaryLinks<T>::look_at(const Cell& cell) {
  const Site site = layout_.site(cell);
  struct Beside {
    std::int32_t body;
    std::uint32_t directions;
  };
  std::array<Beside, d3q19::directions> bodies{};
  std::size_t count = 0;
  std::uint32_t second_cells = 0;
  const bool solid = map_.owner(site.index) > BodyMap::fluid;
  for (int alpha = 1; alpha < d3q19::directions && !solid; ++alpha) {
    const auto& e = d3q19::e[alpha];
    const std::int32_t owner = map_.owner(site.index + layout_.neighbour(alpha));
    if (owner > BodyMap::fluid) {
      const auto end = bodies.begin() + count;
      const auto known = std::find_if(bodies.begin(), end, [&](const Beside& b) { return b.body == owner - 1; });
      if (known == end) *known = {owner - 1, 0}, ++count;
      known->directions |= 1U << alpha;
    } else if (site.faces == 0 || map_.domain().canonical({cell[0] + e[0], cell[1] + e[1], cell[2] + e[2]})) {
      second_cells |= 1U << d3q19::opposite(alpha);
    }
  }
  const std::span<const Beside> beside(bodies.data(), count);
  const Cell& low = layout_.block().low;
  BoundaryRow& in_row = rows_[row(cell[0] - low[0], cell[1] - low[1])];
  for (std::uint32_t i = in_row.first_cell + in_row.cells; i-- > in_row.first_cell;) {
    if (arrays_.z[i] != cell[2] - low[2]) continue;
    const auto body = static_cast<std::int32_t>(arrays_.cells[i].body);
    if (std::ranges::find(beside, body, &Beside::body) == beside.end()) remove(in_row, i);
  }
  for (const auto& [body, directions] : beside) set(body, cell, directions, second_cells);
}

template <class T>
void BoundaryLinks<T>::set(std::int32_t body, const Cell& cell, std::uint32_t directions, std::uint32_t second_cells) {
  const auto number = static_cast<std::uint32_t>(body);
  const Cell& low = layout_.block().low;
  const Cell local = {cell[0] - low[0], cell[1] - low[1], cell[2] - low[2]};
  BoundaryRow& in_row = rows_[row(local[0], local[1])];
  for (std::uint32_t i = in_row.first_cell; i < in_row.first_cell + in_row.cells; ++i) {
    const CellInRow& known = arrays_.cells[i];
    if (arrays_.z[i] != local[2] || known.body != number) continue;
    CellGroup& group = group_of(known);
    if (group.directions[known.place.lane] == directions) {
      group.second_cells[known.place.lane] = second_cells;
      return;
    }
    remove(in_row, i);
    break;
  }
  if (directions != 0) add(in_row, local, number, directions, second_cells);
}

/// Cells of a row from `cell` on, and links from `link` on, move by so many places.
template <class T>
void BoundaryLinks<T>::move(BoundaryRow& row, std::uint32_t cell, std::int32_t cells, std::uint32_t link,
                            std::int32_t links) {
  const auto move = [](auto& array, std::size_t values, std::uint32_t from, std::uint32_t end, std::int32_t by) {
    const auto first = array.begin() + values * from;
    const auto last = array.begin() + values * end;
    const std::ptrdiff_t distance = static_cast<std::ptrdiff_t>(values) * by;
    if (by < 0)
      std::copy(first, last, first + distance);
    else
      std::copy_backward(first, last, last + distance);
  };
  const std::uint32_t end = row.first_cell + row.cells;
  each_by_link(arrays_, arrays_, [&](const auto&, auto& array, std::size_t values) {
    move(array, values, link, row.first_link + row.links, links);
  });
  each_by_cell(arrays_, arrays_,
               [&](const auto&, auto& array, std::size_t values) { move(array, values, cell, end, cells); });
  row.links += links;
  row.cells += cells;
  links_in_use_ += links;
  for (std::uint32_t i = cell; i < end; ++i) {
    const CellInRow& moved = arrays_.cells[i + cells];
    CellGroup& group = group_of(moved);
    group.first_link[moved.place.lane] += links;
    group.moments[moved.place.lane] += cells;
  }
}

template <class T>
void BoundaryLinks<T>::add(BoundaryRow& row, const Cell& local, std::uint32_t body, std::uint32_t directions,
                           std::uint32_t second_cells) {
  const auto links = static_cast<std::uint32_t>(std::popcount(directions));
  if (row.links + links > row.room_for_links || row.cells == row.room_for_cells) append(row, arrays_, arrays_, links);
  const std::array cell = {static_cast<std::int32_t>(local[0]), static_cast<std::int32_t>(local[1]),
                           static_cast<std::int32_t>(local[2])};
  std::uint32_t place_of_cell = row.first_cell + row.cells;
  std::uint32_t first_link = row.first_link + row.links;
  while (place_of_cell > row.first_cell && arrays_.z[place_of_cell - 1] > cell[2]) {
    const CellInRow& later = arrays_.cells[--place_of_cell];
    first_link = group_of(later).first_link[later.place.lane];
  }
  move(row, place_of_cell, 1, first_link, static_cast<std::int32_t>(links));
  const SurfacePlace place = surfaces_[body].add(cell, directions, second_cells);
  CellGroup& group = surfaces_[body].groups[place.group];
  group.moments[place.lane] = place_of_cell;
  group.first_link[place.lane] = first_link;
  arrays_.z[place_of_cell] = cell[2];
  arrays_.cells[place_of_cell] = {body, place};
  LinkInRow* link = arrays_.links.data() + first_link;
  for (std::uint32_t bits = directions; bits != 0; bits &= bits - 1)
    *link++ = cell[2] << direction_bits | std::countr_zero(bits);
  new_cells_.push_back({body, place});
}

template <class T>
void BoundaryLinks<T>::remove(BoundaryRow& row, std::uint32_t cell) {
  const CellInRow removed = arrays_.cells[cell];
  const CellGroup& group = group_of(removed);
  const std::uint32_t end_of_links = group.first_link[removed.place.lane] + group.links;
  surfaces_[removed.body].remove(removed.place);
  move(row, cell + 1, -1, end_of_links, -static_cast<std::int32_t>(group.links));
}

/// Memory for so many boundary cells more: arrays that grow step by step would be in memory twice.
template <class T>
void BoundaryLinks<T>::reserve(std::size_t cells) {
  constexpr std::size_t links_of_cell = 6;  // more than on average, but what is not used takes no memory
  const auto reserve = [](auto& array, std::size_t more) { array.reserve(array.size() + more); };
  each_by_link(arrays_, arrays_,
               [&](const auto&, auto& array, std::size_t values) { reserve(array, values * links_of_cell * cells); });
  each_by_cell(arrays_, arrays_,
               [&](const auto&, auto& array, std::size_t values) { reserve(array, values * 2 * cells); });
}

/// Appends a row to arrays, those in which it is or others, with room for so many more links and some. A row that is
/// the last of its arrays stays where it is.
template <class T>
void BoundaryLinks<T>::append(BoundaryRow& row, const Arrays& from, Arrays& to, std::uint32_t links) {
  const BoundaryRow before = row;
  const bool stays = &from == &to && row.first_link + row.room_for_links == to.links.size();
  if (!stays) {
    row.first_link = to.links.size();
    row.first_cell = to.cells.size();
  }
  row.room_for_links = row.links + links + row.links / 4 + 8;
  row.room_for_cells = row.cells + row.cells / 4 + 4;
  const auto make_room = [&](const auto& old, auto& array, std::size_t first, std::size_t first_before,
                             std::size_t count, std::size_t room) {
    array.resize(first + room);
    if (!stays) std::copy_n(old.begin() + first_before, count, array.begin() + first);
  };
  each_by_link(from, to, [&](const auto& old, auto& array, std::size_t values) {
    make_room(old, array, values * row.first_link, values * before.first_link, values * row.links,
              values * row.room_for_links);
  });
  each_by_cell(from, to, [&](const auto& old, auto& array, std::size_t values) {
    make_room(old, array, values * row.first_cell, values * before.first_cell, values * row.cells,
              values * row.room_for_cells);
  });
  if (stays) return;
  for (std::uint32_t i = row.first_cell; i < row.first_cell + row.cells; ++i) {
    const CellInRow& moved = to.cells[i];
    CellGroup& group = group_of(moved);
    group.first_link[moved.place.lane] += row.first_link - before.first_link;
    group.moments[moved.place.lane] = i;
  }
}

/// Puts rows next to each other again, in their order, which is that of the bulk update, and fills groups: as bodies
/// move, rows find their places behind the others, and lanes become free. Before the next fetch new cells must keep
/// their places.
template <class T>
void BoundaryLinks<T>::put_in_order() {
  Arrays in_order = empty_arrays();
  std::vector<BodySurface> filled(surfaces_.size());
  for (BoundaryRow& row : rows_) {
    if (row.cells == 0) {
      row = {};
      continue;
    }
    append(row, arrays_, in_order, 0);
    for (std::uint32_t i = row.first_cell; i < row.first_cell + row.cells; ++i) {
      CellInRow& cell = in_order.cells[i];
      filled[cell.body].move_here(group_of(cell), cell.place);
    }
  }
  arrays_ = std::move(in_order);
  surfaces_ = std::move(filled);
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
  const CellGroup& group = surfaces_[body].groups[place.group];
  const std::uint32_t directions = group.directions[place.lane];
  if (directions == 0) return;  // the lane is free again
  using Values = BoundaryValues<T>;
  const Site site = layout_.site(group.cell[0][place.lane], group.cell[1][place.lane], group.cell[2][place.lane]);
  const Moments<double> m = moments_at(populations, placement, site);
  double* const of_cell = arrays_.values.by_cell.data() + Values::per_cell(second_cells_) * group.moments[place.lane];
  of_cell[Values::excess_density] = m.excess_density;
  std::uint32_t link = group.first_link[place.lane];
  for (std::uint32_t bits = directions; bits != 0; bits &= bits - 1, ++link) {
    const int alpha = std::countr_zero(bits);
    T* const of_link = values_of_link(link);
    of_link[Values::crossing] = populations[layout_.location(site, alpha, placement)];
    if (second_cells_) of_link[Values::inward] = populations[layout_.location(site, d3q19::opposite(alpha), placement)];
  }
  if (!second_cells_) return;
  for (std::size_t axis = 0; axis < 3; ++axis) of_cell[Values::momentum + axis] = m.momentum[axis];
}

/// f̃_α(x_f − e_α) of all links, where it enters x_f. They are scattered over memory, but row by row they are in the
/// order of as many streams as there are directions. Values of second cells that are not fluid are not used.
template <class T>
void BoundaryLinks<T>::read_second_cells(const T* populations, Placement placement) {
  const std::int64_t rows_of_plane = layout_.block().extent(1);
  const std::int64_t last = layout_.block().extent(2) - 1;
  for (std::size_t number = 0; number < rows_.size(); ++number) {
    const BoundaryRow& of_row = rows_[number];
    if (of_row.links == 0) continue;
    const std::int64_t x = static_cast<std::int64_t>(number) / rows_of_plane;
    const std::int64_t y = static_cast<std::int64_t>(number) % rows_of_plane;
    const Site middle = layout_.in_row(x, y, 0);
    std::array<const T*, d3q19::directions> enters{};
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      enters[alpha] = populations + layout_.entry(middle, alpha, placement);
    constexpr std::uint32_t ahead = 32;
    const std::uint32_t end = of_row.first_link + of_row.links;
    for (std::uint32_t link = of_row.first_link; link < end; ++link) {
      if (link + ahead < end) {
        const LinkInRow later = arrays_.links[link + ahead];
        __builtin_prefetch(enters[direction_of(later)] + z_of(later));
      }
      const std::uint32_t alpha = direction_of(arrays_.links[link]);
      const std::int64_t z = z_of(arrays_.links[link]);
      values_of_link(link)[BoundaryValues<T>::behind] =
          z == 0 || z == last ? populations[layout_.entry(layout_.site(x, y, z), static_cast<int>(alpha), placement)]
                              : enters[alpha][z];
    }
  }
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
    read(populations, placement, new_cells_[i].body, new_cells_[i].place);
  }
  new_cells_ = {};  // with its memory: at first all boundary cells are new
  if (second_cells_) read_second_cells(populations, placement);
}

template <class T>
void BoundaryLinks<T>::forget_populations() {
  new_cells_.clear();
  for (const BoundaryRow& row : rows_)
    for (std::uint32_t i = row.first_cell; i < row.first_cell + row.cells; ++i) new_cells_.push_back(arrays_.cells[i]);
}

template <class T>
RowsBesideBodies<T> BoundaryLinks<T>::rows() {
  return {.rows = rows_.data(),
          .links = arrays_.links.data(),
          .z = arrays_.z.data(),
          .by_link = arrays_.values.by_link.data(),
          .by_cell = arrays_.values.by_cell.data(),
          .second_cells = second_cells_};
}

}  // namespace copepod::fluid
