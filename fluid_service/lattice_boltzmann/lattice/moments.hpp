#pragma once

#include <array>

#include <Eigen/Core>

#include "lattice_boltzmann/lattice/population_layout.hpp"

// Populations of one cell and their moments, in double whatever the solver stores. Populations are deviations
// f_α − w_α.

namespace copepod::fluid {

using Populations = std::array<double, d3q19::directions>;

/// Equilibrium deviation f_α^{eq}(ρ, u) − w_α for excess density δρ = ρ − 1:
///   w_α [δρ + ρ (3 e·u + 9/2 (e·u)² − 3/2 u²)]                                        [paper, eq. (3)]
inline double equilibrium_deviation(int alpha, double excess_density, const double (&u)[3]) {
  const auto& e = d3q19::e[alpha];
  const double eu = e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
  const double uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
  return d3q19::weight(alpha) * (excess_density + (1.0 + excess_density) * (3.0 * eu + 4.5 * eu * eu - 1.5 * uu));
}

/// Of all directions.
inline Populations equilibrium(double excess_density, const Eigen::Vector3d& u) {
  const double velocity[3] = {u[0], u[1], u[2]};
  Populations f;
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    f[static_cast<std::size_t>(alpha)] = equilibrium_deviation(alpha, excess_density, velocity);
  return f;
}

/// δρ = Σ (f_α − w_α), for any f that is called with a direction. Pairs are added first: the sum is then the
/// same for a cell and its mirror image.
template <class Population>
double excess_density(const Population& f) {
  double axes = 0.0;
  double diagonals[3] = {0.0, 0.0, 0.0};
  for (int alpha = 1; alpha < d3q19::directions; alpha += 2) {
    const double pair = static_cast<double>(f(alpha)) + static_cast<double>(f(alpha + 1));
    if (alpha < 7)
      axes += pair;
    else
      diagonals[(alpha - 7) / 4] += pair;
  }
  return (static_cast<double>(f(0)) + axes) + (diagonals[0] + diagonals[1] + diagonals[2]);
}

template <class T>
double excess_density_of_cell(const T* populations, const PopulationLayout& layout, const Site& cell,
                              Placement placement) {
  return excess_density([&](int alpha) { return populations[layout.location(cell, alpha, placement)]; });
}

/// Excess density δρ = Σ (f̃_α − w_α) and momentum Σ f̃_α e_α of one cell, lattice units.
struct CellMoments {
  double excess_density = 0.0;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
};

/// For any f that is called with a direction; the same for a cell and its mirror image.
template <class Population>
CellMoments moments(const Population& f) {
  const auto odd = [&](int alpha) { return static_cast<double>(f(alpha)) - static_cast<double>(f(alpha + 1)); };
  return {excess_density(f),
          {odd(1) + (odd(7) + odd(9)) + (odd(11) + odd(13)), odd(3) + (odd(7) - odd(9)) + (odd(15) + odd(17)),
           odd(5) + (odd(11) - odd(13)) + (odd(15) - odd(17))}};
}

template <class T>
CellMoments moments_of_cell(const T* populations, const PopulationLayout& layout, const Site& cell,
                            Placement placement) {
  return moments([&](int alpha) { return populations[layout.location(cell, alpha, placement)]; });
}

}  // namespace copepod::fluid
