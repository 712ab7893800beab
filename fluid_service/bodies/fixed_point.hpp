#pragma once

#include <cmath>
#include <cstdint>

namespace copepod::fluid {

/// Force and torque as integers: sums are exact, so neither the order of links nor the number of ranks
/// matters. One unit is 2⁻⁵⁰ ≈ 9e-16 in lattice units; the range is ±8192.
namespace fixed_point {

inline constexpr double unit = 0x1p-50;

inline std::int64_t from_double(double value) { return std::llrint(value * (1.0 / unit)); }
inline double to_double(std::int64_t value) { return static_cast<double>(value) * unit; }

}  // namespace fixed_point

/// Six sums per body: force x, y, z, torque x, y, z.
inline constexpr int load_components = 6;

}  // namespace copepod::fluid
