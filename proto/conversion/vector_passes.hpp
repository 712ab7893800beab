#pragma once

#include <cstddef>
#include <cstdint>

namespace copepod::conversion {

/// Functions that pass over all bytes of a large message. There is one build per instruction set; all give
/// the same bits.
struct VectorPasses {
  /// XXH3, 64 bits, seed 0.
  std::uint64_t (*hash)(const void* bytes, std::size_t size);

  /// Copies `count` doubles as they lie in memory; the source need not be aligned.
  /// @return whether all of them are finite
  bool (*copy_finite)(const void* source, std::size_t count, double* target);
};

/// The fastest that this machine has.
const VectorPasses& vector_passes();

extern const VectorPasses kBaselinePasses;

/// @return null on a machine without AVX2
const VectorPasses* vector_passes_avx2();

}  // namespace copepod::conversion
