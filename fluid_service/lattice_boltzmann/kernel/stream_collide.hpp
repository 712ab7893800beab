#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <string>
#include <type_traits>

#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

/// Moments of the cells of a region after its update, cell by cell, z fastest.
struct UpdatedMoments {
  double* excess_density = nullptr;
  std::array<double*, 3> momentum{};  ///< null: not asked for
};

/// Updates the cells of `region` (indices from the block's low corner) by one step: stream, collide, store.
/// Solid cells are updated like fluid ones: no fluid cell ever reads what they produce, since every link into
/// a solid cell is overwritten before the step (boundary/, bodies/), and the loop stays free of branches.
///
/// Every cell is computed by the same sequence of IEEE operations whether it falls into the vector body or
/// the remainder, and whatever the instruction set: no contraction to fused multiply-adds.
/// @param moments  receives those of the cells; null: not needed
template <class T>
using StreamCollide = void (*)(T* populations, const PopulationLayout& layout, Placement placement, const Box& region,
                               const CollisionConstants<T>& constants, bool has_force, const UpdatedMoments* moments);

/// The fastest build of the kernel that this machine can run.
template <class T>
struct KernelChoice {
  StreamCollide<T> update;
  std::string instruction_set;  ///< "avx512", "avx2" or "baseline"
};

template <class T>
KernelChoice<T> choose_stream_collide();

/// A particular build, for tests and benchmarks; null if this machine cannot run it.
template <class T>
StreamCollide<T> stream_collide_baseline();
template <class T>
StreamCollide<T> stream_collide_avx2();
template <class T>
StreamCollide<T> stream_collide_avx512();

// The loop around `collide`, compiled once per instruction set (avx512.cpp, avx2.cpp, baseline.cpp). `Isa` is a tag
// type of the including file: it keeps the instantiations of different instruction sets apart.

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

  /// In double, whatever the kernel computes with.
  template <int w>
  [[gnu::always_inline]] static void store_moments(const Cells<w> (&g)[d3q19::directions],
                                                   const UpdatedMoments& updated, std::int64_t cell) {
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
      if (!updated.momentum[0]) continue;
      for (std::size_t axis = 0; axis < 3; ++axis)
        std::memcpy(updated.momentum[axis] + cell + first, &m.momentum[axis], sizeof(Result));
    }
  }

  /// @param cell  place of cell z in `moments`
  template <int w, bool streamed, bool has_force, bool has_moments>
  [[gnu::always_inline]] static void update(T* const (&row)[d3q19::directions], std::int64_t z,
                                            const CollisionConstants<T>& constants, const UpdatedMoments* moments,
                                            std::int64_t cell) {
    using U = Cells<w>;
    U g[d3q19::directions];
    // Home: the slot that receives α afterwards holds ᾱ now. Streamed: the other way round.
#pragma GCC unroll 19
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      std::memcpy(&g[streamed ? alpha : d3q19::opposite(alpha)], row[alpha] + z, sizeof(U));
    collide<has_force>(g, constants);
#pragma GCC unroll 19
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      std::memcpy(row[alpha] + z, &g[streamed ? d3q19::opposite(alpha) : alpha], sizeof(U));
    if constexpr (has_moments) store_moments<w>(g, *moments, cell);
  }

  /// From cell z of a row to its end: in packs of w cells, what is left in narrower ones, then cell by cell.
  template <int w, bool streamed, bool has_force, bool has_moments>
  [[gnu::always_inline]] static void finish_row(T* const (&row)[d3q19::directions], std::int64_t z, std::int64_t length,
                                                const CollisionConstants<T>& constants, const UpdatedMoments* moments,
                                                std::int64_t first_cell) {
    for (; z + w <= length; z += w) {
      if (w == width && z % values_per_line == 0) prefetch(row, z + prefetch_lines * values_per_line);
      update<w, streamed, has_force, has_moments>(row, z, constants, moments, first_cell + z);
    }
    if constexpr (w > 1)
      finish_row<(w > narrowest ? w / 2 : 1), streamed, has_force, has_moments>(row, z, length, constants, moments,
                                                                                first_cell);
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

  template <bool streamed, bool has_force, bool has_moments>
  static void rows(T* populations, const PopulationLayout& layout, const Box& region,
                   const CollisionConstants<T>& constants, const UpdatedMoments* moments) {
    const std::int64_t length = region.extent(2);
    std::int64_t first_cell = 0;
    for (std::int64_t x = region.low[0]; x < region.high[0]; ++x)
      for (std::int64_t y = region.low[1]; y < region.high[1]; ++y, first_cell += length) {
        const Site middle = layout.in_row(x, y, region.low[2]);
        Row row;
#pragma GCC unroll 19
        for (int alpha = 0; alpha < d3q19::directions; ++alpha)
          row[alpha] = populations + (streamed ? middle.index + layout.slot(alpha)
                                               : layout.location(middle, alpha, Placement::streamed));
        if constexpr (!streamed) move_row_ends<true>(populations, layout, region, x, y);
        finish_row<width, streamed, has_force, has_moments>(row, 0, length, constants, moments, first_cell);
        if constexpr (!streamed) move_row_ends<false>(populations, layout, region, x, y);
      }
  }

  static void run(T* populations, const PopulationLayout& layout, Placement placement, const Box& region,
                  const CollisionConstants<T>& constants, bool has_force, const UpdatedMoments* moments) {
    static constexpr std::array all = {&rows<false, false, false>, &rows<false, false, true>, &rows<false, true, false>,
                                       &rows<false, true, true>,   &rows<true, false, false>, &rows<true, false, true>,
                                       &rows<true, true, false>,   &rows<true, true, true>};
    const std::size_t choice =
        (placement == Placement::streamed ? 4U : 0U) + (has_force ? 2U : 0U) + (moments != nullptr ? 1U : 0U);
    all[choice](populations, layout, region, constants, moments);
  }
};

}  // namespace copepod::fluid
