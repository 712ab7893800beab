#pragma once

#include <cstring>

#include "conversion/vector_passes.hpp"

#define XXH_INLINE_ALL  // compiled for the instruction set of the file, and the kit's users need no library
                        // for it
#include <xxhash.h>

// Compiled once per instruction set (vector_passes_avx2.cpp, vector_passes_baseline.cpp); in a namespace of
// each file, so that the linker does not take one for the other.
namespace copepod::conversion {
namespace {

std::uint64_t hash(const void* bytes, std::size_t size) { return XXH3_64bits(bytes, size); }

bool copy_finite(const void* source, std::size_t count, double* target) {
  FiniteCheck check;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t bits;
    std::memcpy(&bits, static_cast<const std::byte*>(source) + i * sizeof(bits), sizeof(bits));
    check.add(bits);
    std::memcpy(target + i, &bits, sizeof(bits));
  }
  return check.passed();
}

}  // namespace
}  // namespace copepod::conversion
