#pragma once

#include "lattice_boltzmann/lattice/d3q19.hpp"

// Link formulas: what a body's surface sends back along a link. Each is a type with `uses_wall_distance` and
// `returning`; choose_momentum_exchange picks the one named in the case.

namespace copepod::fluid {

/// A link from a fluid cell x_f in direction α into a body, lattice units.
struct Link {
  int direction = 0;           ///< α
  double leaving = 0.0;        ///< f̃_α(x_f) − w_α
  double density = 0.0;        ///< ρ_w, that of the fluid cell
  double e_dot_u_w = 0.0;      ///< e_α·u_w
  double wall_distance = 0.0;  ///< q: the surface is at x_f + q e_α; only where the formula uses it
};

/// Moving bounce-back [paper, section 2.3; Ladd 1994], as if the surface were half-way, q = 1/2:
///   f_ᾱ(x_f) = f̃_α(x_f) − 6 w_α ρ_w e_α·u_w
struct BounceBack {
  static constexpr bool uses_wall_distance = false;

  /// @return f_ᾱ(x_f) − w_ᾱ
  static double returning(const Link& link) {
    return link.leaving - 6.0 * d3q19::weight(link.direction) * link.density * link.e_dot_u_w;
  }
};

}  // namespace copepod::fluid
