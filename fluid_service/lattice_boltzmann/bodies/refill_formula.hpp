#pragma once

#include <array>
#include <span>

#include "lattice_boltzmann/lattice/moments.hpp"

// Refill formulas: the populations of a cell that a body has uncovered, from its fluid neighbours. Each is a
// type with `Neighbour` (what a neighbour contributes), `describe` (a neighbour's populations f̃_α − w_α) and
// `fill` (its means over the neighbours, all zero without any, and u_w = U + Ω × r at the cell);
// make_refiller picks the one named in the case.

namespace copepod::fluid {

/// Equilibrium with the surface velocity of the body that left and the mean density of the neighbours
/// [paper, section 2.3].
struct EquilibriumRefill {
  using Neighbour = std::array<double, 1>;  ///< excess density

  static Neighbour describe(const Populations& f) { return {moments(f).excess_density}; }
  static Populations fill(const Neighbour& mean, const Eigen::Vector3d& u_w) { return equilibrium(mean[0], u_w); }
};

/// The same and the mean non-equilibrium part of the neighbours, f̃_α − f_α^{eq} [Caiazzo 2008, there of the
/// neighbour along the normal].
struct NonequilibriumRefill {
  using Neighbour = std::array<double, 1 + d3q19::directions>;  ///< excess density, f̃_α − f_α^{eq}

  static Neighbour describe(const Populations& f) {
    const Moments<double> m = moments(f);
    const Populations at_rest = equilibrium(m.excess_density, m.momentum_vector() / (1.0 + m.excess_density));
    Neighbour result{m.excess_density};
    for (std::size_t alpha = 0; alpha < f.size(); ++alpha) result[1 + alpha] = f[alpha] - at_rest[alpha];
    return result;
  }
  static Populations fill(const Neighbour& mean, const Eigen::Vector3d& u_w) {
    Populations f = equilibrium(mean[0], u_w);
    for (std::size_t alpha = 0; alpha < f.size(); ++alpha) f[alpha] += mean[1 + alpha];
    return f;
  }
};

/// Equilibrium and the populations that carry the mean stress Π of the neighbours, without higher moments
/// [Grad's approximation: Chikatamarla, Ansumali, Karlin 2006; Latt et al. 2008]:
///   f_α = f_α^{eq} + 9/2 w_α (e_α e_α − I/3) : Π,   Π = Σ_α e_α e_α (f̃_α − f_α^{eq})
struct GradRefill {
  using Neighbour = std::array<double, 7>;  ///< excess density, Π_xx, Π_yy, Π_zz, Π_xy, Π_yz, Π_zx

  static Neighbour describe(const Populations& f) {
    const NonequilibriumRefill::Neighbour all = NonequilibriumRefill::describe(f);
    const auto even = [&](int alpha) {  // pairs first: the same for a cell and its mirror image
      const auto place = 1 + static_cast<std::size_t>(alpha);
      return all[place] + all[place + 1];
    };
    Neighbour result{all[0], even(1), even(3), even(5)};
    for (int alpha = 7; alpha < d3q19::directions; alpha += 4) {  // the diagonals of a plane
      const auto& e = d3q19::e[alpha];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t next = (axis + 1) % 3;
        result[1 + axis] += e[axis] * e[axis] * (even(alpha) + even(alpha + 2));
        if (e[axis] * e[next] != 0) result[4 + axis] = e[axis] * e[next] * (even(alpha) - even(alpha + 2));
      }
    }
    return result;
  }
  static Populations fill(const Neighbour& mean, const Eigen::Vector3d& u_w) {
    Populations f = equilibrium(mean[0], u_w);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      const auto& e = d3q19::e[alpha];
      double product = -(mean[1] + mean[2] + mean[3]) / 3.0;
      for (std::size_t axis = 0; axis < 3; ++axis)
        product += e[axis] * e[axis] * mean[1 + axis] + 2.0 * e[axis] * e[(axis + 1) % 3] * mean[4 + axis];
      f[static_cast<std::size_t>(alpha)] += 4.5 * d3q19::weight(alpha) * product;
    }
    return f;
  }
};

}  // namespace copepod::fluid
