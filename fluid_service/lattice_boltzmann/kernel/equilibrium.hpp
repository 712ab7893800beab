#pragma once

#include "lattice_boltzmann/lattice/d3q19.hpp"

namespace copepod::fluid {

/// Equilibrium deviation f_α^{eq}(ρ, u) − w_α for excess density δρ = ρ − 1:
///   w_α [δρ + ρ (3 e·u + 9/2 (e·u)² − 3/2 u²)]                                        [paper, eq. (3)]
inline double equilibrium_deviation(int alpha, double excess_density, const double (&u)[3]) {
  const auto& e = d3q19::e[alpha];
  const double eu = e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
  const double uu = u[0] * u[0] + u[1] * u[1] + u[2] * u[2];
  return d3q19::weight(alpha) *
         (excess_density + (1.0 + excess_density) * (3.0 * eu + 4.5 * eu * eu - 1.5 * uu));
}

}  // namespace copepod::fluid
