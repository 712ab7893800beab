#pragma once

#include <array>
#include <type_traits>

#include <Eigen/Core>

#include "lattice_boltzmann/lattice/d3q19.hpp"

// Populations of one cell, their moments and their equilibrium. Populations are deviations f_α − w_α.

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
    f[alpha] = equilibrium_deviation(alpha, excess_density, velocity);
  return f;
}

/// Excess density δρ = Σ g_α and momentum j = Σ g_α e_α of deviations g_α = f_α − w_α.
template <class V>
struct Moments {
  V excess_density;
  V momentum[3];

  [[nodiscard]] Eigen::Vector3d momentum_vector() const { return {momentum[0], momentum[1], momentum[2]}; }
};

/// The sums are grouped so that mirror images and opposite directions are treated alike.
/// @param g  19 numbers, or SIMD packs of numbers
template <class G>
[[gnu::always_inline]] inline auto moments(const G& g) {
  using V = std::remove_cvref_t<decltype(g[0])>;
  const V axes = (g[1] + g[2]) + (g[3] + g[4]) + (g[5] + g[6]);
  const V diagonals =
      ((g[7] + g[8]) + (g[9] + g[10])) + ((g[11] + g[12]) + (g[13] + g[14])) + ((g[15] + g[16]) + (g[17] + g[18]));
  const V d7 = g[7] - g[8];
  const V d9 = g[9] - g[10];
  const V d11 = g[11] - g[12];
  const V d13 = g[13] - g[14];
  const V d15 = g[15] - g[16];
  const V d17 = g[17] - g[18];
  return Moments<V>{g[0] + axes + diagonals,
                    {(g[1] - g[2]) + (d7 + d9) + (d11 + d13), (g[3] - g[4]) + (d7 - d9) + (d15 + d17),
                     (g[5] - g[6]) + (d11 - d13) + (d15 - d17)}};
}

}  // namespace copepod::fluid
