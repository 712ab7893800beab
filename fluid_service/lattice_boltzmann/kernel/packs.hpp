#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

// Arithmetic of numbers (V: double) and SIMD packs of them, with the same bits for each.

namespace copepod::fluid {

/// Whether a mask, of lanes or of one number, has only ones.
template <class Mask>
[[gnu::always_inline]] inline bool all(const Mask& mask) {
  if constexpr (std::is_same_v<Mask, bool>) {
    return mask;
  } else {
    constexpr std::size_t width = sizeof(Mask) / sizeof(std::int64_t);
    using Bytes [[gnu::vector_size(width)]] = std::int8_t;
    const Bytes bytes = __builtin_convertvector(mask, Bytes);
    std::uint64_t bits = ~std::uint64_t{0};
    std::memcpy(&bits, &bytes, width);
    return bits == ~std::uint64_t{0};
  }
}

template <class V>
[[gnu::always_inline]] inline V square_root(const V& x) {
  double lanes[sizeof(V) / sizeof(std::int64_t)];
  std::memcpy(lanes, &x, sizeof(x));
  for (double& lane : lanes) lane = __builtin_sqrt(lane);
  V result;
  std::memcpy(&result, lanes, sizeof(result));
  return result;
}

template <class X, class V>
[[gnu::always_inline]] inline V dot(const X* a, const V* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// (x × y)_a
template <class X, class V>
[[gnu::always_inline]] inline V cross(const X* x, const V* y, std::size_t a) {
  return x[(a + 1) % 3] * y[(a + 2) % 3] - x[(a + 2) % 3] * y[(a + 1) % 3];
}

/// A x
template <class V>
[[gnu::always_inline]] inline void multiply(const double* A, const V (&x)[3], V (&product)[3]) {
  for (std::size_t a = 0; a < 3; ++a) product[a] = dot(A + 3 * a, x);
}

}  // namespace copepod::fluid
