#pragma once

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

// Collision of one cell: arithmetic on 19 values only, no memory layout, no loops over cells, so that a
// device compiler can take it as it is. `V` is a floating-point value or a SIMD pack of them, `T` the scalar.

namespace copepod::fluid {

/// Constants of a two-relaxation-time collision [Ginzburg, Verhaeghe, d'Humières 2008]; BGK is the case of
/// equal rates.
template <class T>
struct CollisionConstants {
  T half_rate_even;  ///< ω⁺/2, relaxes the symmetric half of a pair; ω⁺ = 1/τ sets the viscosity
  T half_rate_odd;   ///< ω⁻/2, relaxes the antisymmetric half
  T force[3];        ///< body force F, lattice units
};

template <class T>
double even_time(const CollisionConstants<T>& c) {
  return 0.5 / static_cast<double>(c.half_rate_even);
}
template <class T>
double odd_time(const CollisionConstants<T>& c) {
  return 0.5 / static_cast<double>(c.half_rate_odd);
}

/// τ⁻ of the pair's antisymmetric half: τ⁻ − 1/2 = Λ / (τ − 1/2) with Λ = 3/16, which puts a half-way
/// bounce-back wall of a Poiseuille flow exactly half-way [Ginzburg, Verhaeghe, d'Humières 2008]; for BGK τ⁻
/// = τ.
template <class T>
CollisionConstants<T> collision_constants(CollisionKind kind, double relaxation_time,
                                          const Eigen::Vector3d& body_force_lu) {
  constexpr double magic = 3.0 / 16.0;
  const double odd_time = kind == CollisionKind::bgk ? relaxation_time : 0.5 + magic / (relaxation_time - 0.5);
  return {static_cast<T>(0.5 / relaxation_time),
          static_cast<T>(0.5 / odd_time),
          {static_cast<T>(body_force_lu[0]), static_cast<T>(body_force_lu[1]), static_cast<T>(body_force_lu[2])}};
}

/// Collides one cell in place:
///   g̃_α = g_α − ω⁺ (g_α⁺ − g_α^{eq+}) − ω⁻ (g_α⁻ − g_α^{eq−}) + source       [paper, eq. (3), for ω⁺ = ω⁻]
///   f_α^{eq} = w_α [ρ + 3 e·j + (9/2 (e·j)² − 3/2 j²) / ρ]
/// with ± the even and odd halves of a pair. With a force [Guo, Zheng, Shi 2002]: j is taken at half the
/// step, j = Σ g_α e_α + F/2, and the source's halves are (1 − ω⁺/2) w_α (9 (e·u)(e·F) − 3 u·F) and (1 −
/// ω⁻/2) 3 w_α e·F.
/// @param g  deviations f_α − w_α; pre-collision in, post-collision out
template <bool has_force, class V, class T>
[[gnu::always_inline]] inline void collide(V (&g)[d3q19::directions], const CollisionConstants<T>& c) {
  Moments<V> m = moments(g);
  if constexpr (has_force)
    for (int a = 0; a < 3; ++a) m.momentum[a] = m.momentum[a] + T(0.5) * c.force[a];
  const V jx = m.momentum[0];
  const V jy = m.momentum[1];
  const V jz = m.momentum[2];
  const V inverse_density = T(1) / (T(1) + m.excess_density);
  // k = δρ − 3/2 j²/ρ is what all directions share; (e·j)² is divided by ρ through h = 9/2 / ρ.
  const V h = T(4.5) * inverse_density;
  const V shared = m.excess_density - (jx * jx + jy * jy + jz * jz) * (T(1.5) * inverse_density);

  V force_dot_u{};
  if constexpr (has_force) force_dot_u = (c.force[0] * jx + c.force[1] * jy + c.force[2] * jz) * inverse_density;

  const T keep_even = T(1) - c.half_rate_even;  // 1 − ω⁺/2
  const T keep_odd = T(1) - c.half_rate_odd;

  {
    constexpr T w0 = T(d3q19::weight(0));
    V rest = g[0] - T(2) * c.half_rate_even * (g[0] - w0 * shared);
    if constexpr (has_force) rest = rest - keep_even * (T(3) * w0) * force_dot_u;
    g[0] = rest;
  }

  // One pair (α, ᾱ): q = e·j, b = e·F.
  const auto relax_pair = [&](int alpha, const V& q, T b) __attribute__((always_inline)) {
    const T w = T(d3q19::weight(alpha));
    const V even = g[alpha] + g[alpha + 1];
    const V odd = g[alpha] - g[alpha + 1];
    V even_change = c.half_rate_even * (even - (w + w) * (shared + h * q * q));
    V odd_change = c.half_rate_odd * (odd - (T(6) * w) * q);
    if constexpr (has_force) {
      even_change = even_change - keep_even * w * (T(9) * b * q * inverse_density - T(3) * force_dot_u);
      odd_change = odd_change - keep_odd * (T(3) * w) * b;
    }
    g[alpha] = g[alpha] - even_change - odd_change;
    g[alpha + 1] = g[alpha + 1] - even_change + odd_change;
  };
  const T* f = c.force;
  relax_pair(1, jx, f[0]);
  relax_pair(3, jy, f[1]);
  relax_pair(5, jz, f[2]);
  relax_pair(7, jx + jy, f[0] + f[1]);
  relax_pair(9, jx - jy, f[0] - f[1]);
  relax_pair(11, jx + jz, f[0] + f[2]);
  relax_pair(13, jx - jz, f[0] - f[2]);
  relax_pair(15, jy + jz, f[1] + f[2]);
  relax_pair(17, jy - jz, f[1] - f[2]);
}

}  // namespace copepod::fluid
