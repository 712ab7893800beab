#pragma once

#include <chrono>
#include <cstdint>

#include "lattice_boltzmann/lattice/huge_array.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

// What the machine's memory allows: the limits that the fluid's speed is judged by.

namespace copepod::fluid::benchmark {

inline double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Reads and writes the 19 slots of every cell of the block in place, with one multiplication each and
/// nothing else: the memory traffic of an in-place update without its arithmetic, prefetched
/// like the kernel's (kernel/stream_collide.hpp).
template <class T>
void touch_streams(T* populations, const PopulationLayout& layout) {
  using Pack [[gnu::vector_size(32), gnu::aligned(sizeof(T)), gnu::may_alias]] = T;
  constexpr auto width = static_cast<std::int64_t>(32 / sizeof(T));
  const Box& block = layout.block();
  for (std::int64_t x = 0; x < block.extent(0); ++x)
    for (std::int64_t y = 0; y < block.extent(1); ++y) {
      T* row = populations + layout.cell(x, y, 0);
      for (std::int64_t z = 0; z + width <= block.extent(2); z += width)
#pragma GCC unroll 19
        for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
          __builtin_prefetch(row + layout.slot(alpha) + z + 8 * width, 1);
          Pack* pack = reinterpret_cast<Pack*>(row + layout.slot(alpha) + z);
          *pack = *pack * T(0.9999999);
        }
    }
}

/// Bytes per second of a copy between two arrays much larger than the caches, each counted once.
inline double copy_rate(HugeArray<double>& target, const HugeArray<double>& source) {
  const auto start = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < source.size(); ++i) target[i] = source[i] + 1.0;
  return 2.0 * 8.0 * static_cast<double>(source.size()) / seconds_since(start);
}

}  // namespace copepod::fluid::benchmark
