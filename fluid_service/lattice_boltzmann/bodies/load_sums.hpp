#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace copepod::fluid {

/// Force and torque as integers: sums are exact, so neither the order of links nor the number of ranks
/// matters. One unit is 2⁻⁵⁰ ≈ 9e-16 in lattice units.
///
/// What one cell adds to a force fits 64 bits (±8192), the sums over a body need more: the torque of the
/// first step grows with the cube of the radius. They have 128 bits, and no body is too large for them.
namespace fixed_point {

__extension__ using Sum = __int128;

inline constexpr double unit = 0x1p-50;

/// @param value  below 8192
inline std::int64_t from_double(double value) { return std::llrint(value * (1.0 / unit)); }
inline double to_double(std::int64_t value) { return static_cast<double>(value) * unit; }

/// The same for any value. From 2⁵³ units on a double is a multiple of the unit by itself.
inline Sum sum_from_double(double value) {
  return std::abs(value) < 4096.0 ? Sum{from_double(value)} : static_cast<Sum>(value * (1.0 / unit));
}
inline double to_double(Sum value) { return static_cast<double>(value) * unit; }

/// A sum as low + 2⁴⁴ high with 0 ≤ low < 2⁴⁴, for messages: each half is added up by itself, which is exact
/// for 2¹⁹ ranks and sums up to 2⁵⁷ ≈ 1.4e17 in lattice units. 10⁹ links at 10⁴ cells from the centre, all
/// with the largest population that is let through, stay below 10¹⁶.
using Halves = std::array<std::int64_t, 2>;
inline constexpr int low_bits = 44;

inline Halves halves(Sum value) {
  return {static_cast<std::int64_t>(value & ((Sum{1} << low_bits) - 1)), static_cast<std::int64_t>(value >> low_bits)};
}
inline Sum from_halves(std::int64_t low, std::int64_t high) { return low + (Sum{high} << low_bits); }

}  // namespace fixed_point

/// Sums per body: force x, y, z, torque x, y, z, mass absorbed, weights w_α of the links.
inline constexpr std::size_t load_components = 8;
inline constexpr std::size_t mass_component = 6;
inline constexpr std::size_t weight_component = 7;
using LoadSums = std::array<fixed_point::Sum, load_components>;
/// x, y, z.
using MomentumSums = std::array<fixed_point::Sum, 3>;

}  // namespace copepod::fluid
