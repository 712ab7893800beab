#pragma once

#include <array>
#include <span>

#include "lattice_boltzmann/lattice/moments.hpp"

// Refill formulas: the populations of a cell that a body has uncovered. Each is a type with `Neighbour` (what
// a fluid cell beside it contributes), `describe` and `fill`; make_refiller picks the one named in the case.

namespace copepod::fluid {

/// Equilibrium with the surface velocity of the body that left and the mean density of the neighbouring fluid
/// cells [paper, section 2.3]; without a neighbour the density is that of the fluid at rest.
struct EquilibriumRefill {
  using Neighbour = std::array<double, 1>;  ///< excess density

  /// @param f  populations of the neighbour: f(α) = f̃_α − w_α
  template <class Population>
  static Neighbour describe(const Population& f) {
    return {excess_density(f)};
  }

  /// @param neighbours  sorted: the order depends neither on the ranks nor on which mirror image the cell is
  /// @param u_w         U + Ω × r at the cell
  static Populations fill(std::span<const Neighbour> neighbours, const Eigen::Vector3d& u_w) {
    double density = 0.0;
    for (const Neighbour& neighbour : neighbours) density += neighbour[0];
    if (!neighbours.empty()) density /= static_cast<double>(neighbours.size());
    const double velocity[3] = {u_w[0], u_w[1], u_w[2]};
    Populations populations;
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      populations[static_cast<std::size_t>(alpha)] = equilibrium_deviation(alpha, density, velocity);
    return populations;
  }
};

}  // namespace copepod::fluid
