#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "lattice_boltzmann/bodies/boundary_links.hpp"

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
  return {static_cast<std::int64_t>(value & ((Sum{1} << low_bits) - 1)),
          static_cast<std::int64_t>(value >> low_bits)};
}
inline Sum from_halves(std::int64_t low, std::int64_t high) { return low + (Sum{high} << low_bits); }

}  // namespace fixed_point

/// Six sums per body: force x, y, z, torque x, y, z.
inline constexpr std::size_t load_components = 6;
using LoadSums = std::array<fixed_point::Sum, load_components>;

/// A population that a body's surface sends back, to be put in place before the bulk update.
template <class T>
struct ReflectedPopulation {
  std::int64_t location = 0;
  T value{};
};

template <class T>
struct ReflectedPopulations {
  /// By plane x, from the block's low corner, of the fluid cell.
  std::vector<std::vector<ReflectedPopulation<T>>> interior;
  std::vector<ReflectedPopulation<T>> border;  ///< to be applied after other ranks' populations have arrived

  explicit ReflectedPopulations(std::int64_t planes) : interior(static_cast<std::size_t>(planes)) {}
  void clear() {
    for (auto& plane : interior) plane.clear();
    border.clear();
  }
};

/// Sends back what meets a body, by a link formula (link_formula.hpp), and adds up the momentum that the body
/// takes [paper, section 2.3; Yu et al. 2003; Ladd 1994]:
///   u_w = U + Ω × (x_f − X)
///   F = Σ_links e_α (f̃_α + f_ᾱ),   T = Σ_links (x_f − X) × e_α (f̃_α + f_ᾱ)
/// Every point of a link gives the same torque and the same e_α·u_w, so x_f stands for the wall point.
/// Populations are deviations f − w: the constant pressure of the fluid at rest never enters, and bodies that
/// touch feel no spurious force from links that are missing between them.
/// @param cells  of the body, on this rank
/// @param loads  sums to which this rank's share is added
/// @throws SolverError if a population is not finite or absurdly large, naming the cell
template <class T>
using MomentumExchange = void (*)(const T* populations, const PopulationLayout& layout, Placement placement,
                                  const Domain& domain, const LatticeBody& body,
                                  std::span<const BoundaryCell> cells, LoadSums& loads,
                                  ReflectedPopulations<T>& reflected);

/// With the link formula of a case. @throws CaseError for one that this version does not have
template <class T>
MomentumExchange<T> choose_momentum_exchange(MovingBoundary formula);

}  // namespace copepod::fluid
