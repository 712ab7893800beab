#pragma once

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

/// Updates the cells of `region` (indices from the block's low corner) by one step: stream, collide, store.
/// Solid cells are updated like fluid ones: no fluid cell ever reads what they produce, since every link into
/// a solid cell is overwritten before the step (boundary/, bodies/), and the loop stays free of branches.
///
/// Every cell is computed by the same sequence of IEEE operations whether it falls into the vector body or
/// the remainder, and whatever the instruction set: no contraction to fused multiply-adds.
///
/// Rows beside bodies are updated in pieces of a few cache lines: what returns along links is put where the update of
/// a piece reads it while its lines arrive, and what leaves is collected while they are in the cache.
/// @param beside_bodies  boundary cells of the block; null: there are none
template <class T>
using StreamCollide = void (*)(T* populations, const PopulationLayout& layout, Placement placement, const Box& region,
                               const CollisionConstants<T>& constants, bool has_force,
                               const RowsBesideBodies<T>* beside_bodies);

// The loop around `collide`, compiled once per instruction set (avx512.cpp, avx2.cpp, baseline.cpp). `Isa` is a type of
// its own in each, which keeps the instantiations apart.

template <int bytes>
struct VectorsOf {
  static constexpr int vector_bytes = bytes;  ///< 16: of every x86-64 and AArch64
};

template <class T, int width>
using Pack [[gnu::vector_size(sizeof(T) * width)]] = T;

template <class Isa, class T>
struct StreamCollideLoop {
  static constexpr int width = Isa::vector_bytes / static_cast<int>(sizeof(T));
  static constexpr int narrowest = 16 / static_cast<int>(sizeof(T));

  template <int w>
  using Cells = std::conditional_t<w == 1, T, Pack<T, w>>;

  /// The 19 slots of a row's first cell; slot α is read as direction α or ᾱ (Placement).
  using Row = T * [d3q19::directions];

  static constexpr std::int64_t values_per_line = 64 / sizeof(T);
  /// 19 streams are more than the hardware follows: asked for this far ahead, a line is there when it is
  /// needed. Past a row's end lies the next row (docs/decisions/in_place_streaming.md).
  static constexpr std::int64_t prefetch_lines = 4;

  [[gnu::always_inline]] static void prefetch(T* const (&row)[d3q19::directions], std::int64_t z) {
#pragma GCC unroll 19
    for (const auto& populations_of_row : row) __builtin_prefetch(populations_of_row + z, 1);
  }

  /// Cells that are updated between putting back and collecting: lines are asked for as far ahead.
  static constexpr std::int64_t piece = prefetch_lines * values_per_line;

  /// Moments of a piece after its update, in double whatever the kernel computes with.
  struct UpdatedMoments {
    double excess_density[piece];
    double momentum[3][piece];
    bool with_momentum;
  };

  template <int w>
  [[gnu::always_inline]] static void store_moments(const Cells<w> (&g)[d3q19::directions], UpdatedMoments& updated,
                                                   std::int64_t cell) {
    constexpr int at_once = std::min<int>(w, Isa::vector_bytes / static_cast<int>(sizeof(double)));
    using Source = Cells<at_once>;
    using Result = std::conditional_t<at_once == 1, double, Pack<double, at_once>>;
    for (int first = 0; first < w; first += at_once) {
      Result populations[d3q19::directions];
#pragma GCC unroll 19
      for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
        Source source;
        std::memcpy(&source, reinterpret_cast<const T*>(&g[alpha]) + first, sizeof(source));
        if constexpr (at_once == 1)
          populations[alpha] = static_cast<double>(source);
        else
          populations[alpha] = __builtin_convertvector(source, Result);
      }
      const Moments<Result> m = moments(populations);
      std::memcpy(updated.excess_density + cell + first, &m.excess_density, sizeof(Result));
      if (!updated.with_momentum) continue;
      for (std::size_t axis = 0; axis < 3; ++axis)
        std::memcpy(updated.momentum[axis] + cell + first, &m.momentum[axis], sizeof(Result));
    }
  }

  /// @param cell  place of cell z in `updated`, which is null where moments are not needed
  template <int w, bool streamed, CollisionForm form, class Updated>
  [[gnu::always_inline]] static void update(T* const (&row)[d3q19::directions], std::int64_t z,
                                            const CollisionConstants<T>& constants, Updated updated,
                                            std::int64_t cell) {
    using U = Cells<w>;
    U g[d3q19::directions];
    // Home: the slot that receives α afterwards holds ᾱ now. Streamed: the other way round.
#pragma GCC unroll 19
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      std::memcpy(&g[streamed ? alpha : d3q19::opposite(alpha)], row[alpha] + z, sizeof(U));
    collide<form>(g, constants);
#pragma GCC unroll 19
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      std::memcpy(row[alpha] + z, &g[streamed ? d3q19::opposite(alpha) : alpha], sizeof(U));
    if constexpr (!std::is_null_pointer_v<Updated>) store_moments<w>(g, *updated, cell);
  }

  /// From cell z to cell `end`: in packs of w cells, what is left in narrower ones, then cell by cell.
  template <int w, bool streamed, CollisionForm form, class Updated>
  [[gnu::always_inline]] static void update_cells(T* const (&row)[d3q19::directions], std::int64_t first,
                                                  std::int64_t z, std::int64_t end,
                                                  const CollisionConstants<T>& constants, Updated updated) {
    for (; z + w <= end; z += w) {
      if (w == width && z % values_per_line == 0) prefetch(row, z + prefetch_lines * values_per_line);
      update<w, streamed, form>(row, z, constants, updated, z - first);
    }
    if constexpr (w > 1)
      update_cells<(w > narrowest ? w / 2 : 1), streamed, form>(row, first, z, end, constants, updated);
  }

  /// @param low  z of the first cell
  template <bool streamed, CollisionForm form>
  [[gnu::noinline]] static void row_beside_bodies(T* const (&row)[d3q19::directions], std::int64_t low,
                                                  std::int64_t length, const CollisionConstants<T>& constants,
                                                  const RowsBesideBodies<T>& beside, const BoundaryRow& of_row) {
    // Where f̃_α will be after the update, f_ᾱ is before it.
    T* crossing_at[d3q19::directions];
    const T* inward_at[d3q19::directions];
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      crossing_at[streamed ? d3q19::opposite(alpha) : alpha] = row[alpha] - low;
      inward_at[streamed ? alpha : d3q19::opposite(alpha)] = row[alpha] - low;
    }
    std::uint32_t link = of_row.first_link;
    std::uint32_t cell = of_row.first_cell;
    const std::uint32_t last_link = link + of_row.links;
    const std::uint32_t last_cell = cell + of_row.cells;
    while (link < last_link && z_of(beside.links[link]) < low) ++link;
    while (cell < last_cell && beside.z[cell] < low) ++cell;
    UpdatedMoments updated;  // NOLINT(cppcoreguidelines-pro-type-member-init): written before it is read, and large
    updated.with_momentum = beside.second_cells;
    using Values = BoundaryValues<T>;
    const std::size_t per_link = Values::per_link(beside.second_cells);
    const std::size_t per_cell = Values::per_cell(beside.second_cells);
    for (std::int64_t first = 0; first < length; first += piece) {
      const std::int64_t end = std::min(first + piece, length);
      if (cell == last_cell || beside.z[cell] >= low + end) {
        update_cells<width, streamed, form>(row, first, first, end, constants, nullptr);
        continue;
      }
      const std::uint32_t first_link = link;
      for (; link < last_link && z_of(beside.links[link]) < low + end; ++link)
        crossing_at[direction_of(beside.links[link])][z_of(beside.links[link])] =
            beside.by_link[per_link * link + Values::crossing];
      update_cells<width, streamed, form>(row, first, first, end, constants, &updated);
      for (std::uint32_t i = first_link; i < link; ++i) {
        const LinkInRow of = beside.links[i];
        T* const values = beside.by_link + per_link * i;
        values[Values::crossing] = crossing_at[direction_of(of)][z_of(of)];
        if (beside.second_cells) values[Values::inward] = inward_at[direction_of(of)][z_of(of)];
      }
      for (; cell < last_cell && beside.z[cell] < low + end; ++cell) {
        const std::int64_t place = beside.z[cell] - low - first;
        double* const values = beside.by_cell + per_cell * cell;
        values[Values::excess_density] = updated.excess_density[place];
        if (!beside.second_cells) continue;
        for (std::size_t axis = 0; axis < 3; ++axis) values[Values::momentum + axis] = updated.momentum[axis][place];
      }
    }
  }

  /// Slots of a row's end cells that are not in line with the row's others are put there for the time of its
  /// update, and back.
  template <bool into_row>
  [[gnu::always_inline]] static void move_row_ends(T* populations, const PopulationLayout& layout, const Box& region,
                                                   std::int64_t x, std::int64_t y) {
    const std::int64_t last = layout.block().extent(2) - 1;
    const auto move = [&](const Site& end) {
      for (const auto& [slot, in_row] : layout.detours(end.faces)) {
        T* const away = populations + end.index + slot;
        T* const in_line = populations + end.index + in_row;
        if constexpr (into_row) {
          *in_line = *away;
          __builtin_prefetch(away + layout.row_pitch(), 1);
          __builtin_prefetch(in_line + layout.row_pitch(), 1);
        } else {
          *away = *in_line;
        }
      }
    };
    if (region.low[2] == 0) move(layout.site(x, y, 0));
    if (region.high[2] == last + 1 && last > 0) move(layout.site(x, y, last));
  }

  template <bool streamed, CollisionForm form>
  static void rows(T* populations, const PopulationLayout& layout, const Box& region,
                   const CollisionConstants<T>& constants, const RowsBesideBodies<T>* beside_bodies) {
    const std::int64_t length = region.extent(2);
    for (std::int64_t x = region.low[0]; x < region.high[0]; ++x)
      for (std::int64_t y = region.low[1]; y < region.high[1]; ++y) {
        const Site middle = layout.in_row(x, y, region.low[2]);
        Row row;
#pragma GCC unroll 19
        for (int alpha = 0; alpha < d3q19::directions; ++alpha)
          row[alpha] = populations + (streamed ? middle.index + layout.slot(alpha)
                                               : layout.location(middle, alpha, Placement::streamed));
        if constexpr (!streamed) move_row_ends<true>(populations, layout, region, x, y);
        const BoundaryRow* const of_row =
            beside_bodies ? beside_bodies->rows + (x * layout.block().extent(1) + y) : nullptr;
        if (of_row && of_row->cells > 0)
          row_beside_bodies<streamed, form>(row, region.low[2], length, constants, *beside_bodies, *of_row);
        else
          update_cells<width, streamed, form>(row, 0, 0, length, constants, nullptr);
        if constexpr (!streamed) move_row_ends<false>(populations, layout, region, x, y);
      }
  }

  template <CollisionForm form>
  static auto rows_at(Placement placement) {
    return placement == Placement::streamed ? &rows<true, form> : &rows<false, form>;
  }

  static void run(T* populations, const PopulationLayout& layout, Placement placement, const Box& region,
                  const CollisionConstants<T>& constants, bool has_force, const RowsBesideBodies<T>* beside_bodies) {
    using Form = CollisionForm;
    const auto chosen =
        constants.central_moments
            ? (has_force ? rows_at<Form{true, true}>(placement) : rows_at<Form{true, false}>(placement))
            : (has_force ? rows_at<Form{false, true}>(placement) : rows_at<Form{false, false}>(placement));
    chosen(populations, layout, region, constants, beside_bodies);
  }
};

}  // namespace copepod::fluid
