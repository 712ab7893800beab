#pragma once

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

// Collision of one cell: arithmetic on 19 values only, no memory layout, no loops over cells, so that a
// device compiler can take it as it is. `V` is a floating-point value or a SIMD pack of them, `T` the scalar.

namespace copepod::fluid {

/// Constants of a two-relaxation-time collision [Ginzburg, Verhaeghe, d'Humières 2008], of which BGK is the case of
/// equal rates, or of one of central moments.
template <class T>
struct CollisionConstants {
  T half_rate_even;  ///< ω⁺/2, relaxes the symmetric half of a pair; ω⁺ = 1/τ sets the viscosity
  T half_rate_odd;   ///< ω⁻/2, relaxes the antisymmetric half
  T force[3];        ///< body force F, lattice units
  bool central_moments = false;
};

/// What of a collision is known when the kernel is compiled.
struct CollisionForm {
  bool central_moments;
  bool has_force;
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
/// = τ, and central moments leave nothing of the antisymmetric half, τ⁻ = 1.
template <class T>
CollisionConstants<T> collision_constants(CollisionKind kind, double relaxation_time,
                                          const Eigen::Vector3d& body_force_lu) {
  constexpr double magic = 3.0 / 16.0;
  const double odd_time = kind == CollisionKind::bgk               ? relaxation_time
                          : kind == CollisionKind::central_moments ? 1.0
                                                                   : 0.5 + magic / (relaxation_time - 0.5);
  return {static_cast<T>(0.5 / relaxation_time),
          static_cast<T>(0.5 / odd_time),
          {static_cast<T>(body_force_lu[0]), static_cast<T>(body_force_lu[1]), static_cast<T>(body_force_lu[2])},
          kind == CollisionKind::central_moments};
}

/// Collides one cell in place:
///   g̃_α = g_α − ω⁺ (g_α⁺ − g_α^{eq+}) − ω⁻ (g_α⁻ − g_α^{eq−}) + source       [paper, eq. (3), for ω⁺ = ω⁻]
///   f_α^{eq} = w_α [ρ + 3 e·j + (9/2 (e·j)² − 3/2 j²) / ρ]
/// with ± the even and odd halves of a pair. With a force [Guo, Zheng, Shi 2002]: j is taken at half the
/// step, j = Σ g_α e_α + F/2, and the source's halves are (1 − ω⁺/2) w_α (9 (e·u)(e·F) − 3 u·F) and (1 −
/// ω⁻/2) 3 w_α e·F.
/// @param g  deviations f_α − w_α; pre-collision in, post-collision out
template <bool has_force, class V, class T>
[[gnu::always_inline]] inline void relax_halves(V (&g)[d3q19::directions], const CollisionConstants<T>& c) {
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

/// Collides one cell in place by its central moments κ_ab… = Σ f_α (e − u)_a (e − u)_b … [De Rosis, Huang, Coreixas
/// 2019]. Those of the third order, κ_aab, vanish; the trace of the second order takes its equilibrium ρ, which damps
/// sound by a bulk viscosity of 1/9; the rest relaxes with ω:
///   κ̃_ab = ρ/3 δ_ab + (1 − ω)(κ_ab − tr κ δ_ab/3)
/// The moments after the collision, from which the populations follow, are
///   M_ab = κ̃_ab + ρ u_a u_b,   M_aab = u_b M_aa + 2 u_a κ̃_ab,   M_aabb = (M_aa + M_bb)/3 − ρ/9
/// the last with Hermite's of the fourth order being zero [Malaspinas 2015]. With a force, as above, j is taken at half
/// the step: ρ u_a u_b lacks (u_a F_b + u_b F_a)/2 before the collision and has it in addition afterwards, when κ̃_aab
/// is F_b/6; terms u² F are left out.
template <bool has_force, class V, class T>
[[gnu::always_inline]] inline void relax_central_moments(V (&g)[d3q19::directions], const CollisionConstants<T>& c) {
  const Moments<V> m = moments(g);
  T half_force[3] = {};
  V j[3];
  V u[3];
  const V inverse_density = T(1) / (T(1) + m.excess_density);
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    j[a] = m.momentum[a];
    if constexpr (has_force) j[a] = j[a] + (half_force[a] = T(0.5) * c.force[a]);
    u[a] = j[a] * inverse_density;
  }
  struct Flux {
    V before, after;
  };
  const auto momentum_flux = [&](int a, int b) __attribute__((always_inline)) {
    const V flux = u[a] * j[b];
    if constexpr (!has_force) return Flux{flux, flux};
    const V of_force = half_force[b] * u[a] + half_force[a] * u[b];
    return Flux{flux - of_force, flux + of_force};
  };
  const auto even = [&](int alpha) __attribute__((always_inline)) { return g[alpha] + g[alpha + 1]; };
  const V plus[3] = {even(15), even(11), even(7)};  // of the diagonals of planes normal to x, y, z
  const V minus[3] = {even(17), even(13), even(9)};
  V flux[3];
  V normal[3];  // κ_aa − 1/3
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const int d = (a + 2) % 3;
    const Flux of_axis = momentum_flux(a, a);
    flux[a] = of_axis.after;
    normal[a] = even(1 + 2 * a) + ((plus[b] + minus[b]) + (plus[d] + minus[d])) - of_axis.before;
  }
  constexpr T third = T(1.0 / 3.0);
  const V pressure = third * m.excess_density;
  const V mean = third * (normal[0] + normal[1] + normal[2]);
  const V total = flux[0] + flux[1] + flux[2];
  const T keep = T(1) - T(2) * c.half_rate_even;
  V quarter[3];    // M_aa / 4
  V even_half[3];  // of the populations along an axis: their sum and difference, halved
  V odd_half[3];
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    const V second = keep * (normal[a] - mean) + (pressure + flux[a]);
    quarter[a] = T(0.25) * second;
    even_half[a] = third * second - T(0.5 / 3.0) * (pressure + total);
    odd_half[a] = T(0.5) * j[a];
    if constexpr (has_force) odd_half[a] = odd_half[a] + T(0.5) * half_force[a];
  }
  g[0] = pressure - third * total;  // δρ − Σ (M_aa − 1/3) + Σ (M_aabb − 1/9)
#pragma GCC unroll 3
  for (int n = 0; n < 3; ++n) {  // planes of axes a < b, normal to n; quarters of moments
    const int a = n == 0 ? 1 : 0;
    const int b = n == 2 ? 1 : 2;
    const Flux of_plane = momentum_flux(a, b);
    const V shear = keep * ((plus[n] - minus[n]) - of_plane.before);
    const V half_shear = T(0.5) * shear;
    const V ab = T(0.25) * (shear + of_plane.after);
    V aab = u[b] * (quarter[a] + T(0.25 / 3.0)) + u[a] * half_shear;
    V abb = u[a] * (quarter[b] + T(0.25 / 3.0)) + u[b] * half_shear;
    if constexpr (has_force) {
      aab = aab + T(0.25 / 3.0) * half_force[b];
      abb = abb + T(0.25 / 3.0) * half_force[a];
    }
    const V aabb = third * (quarter[a] + quarter[b] - T(0.25) * pressure);
    const int alpha = 15 - 4 * n;
    g[alpha] = (aabb + ab) + (abb + aab);
    g[alpha + 1] = (aabb + ab) - (abb + aab);
    g[alpha + 2] = (aabb - ab) + (abb - aab);
    g[alpha + 3] = (aabb - ab) - (abb - aab);
    odd_half[a] = odd_half[a] - T(2) * abb;
    odd_half[b] = odd_half[b] - T(2) * aab;
  }
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    g[1 + 2 * a] = even_half[a] + odd_half[a];
    g[2 + 2 * a] = even_half[a] - odd_half[a];
  }
}

template <CollisionForm form, class V, class T>
[[gnu::always_inline]] inline void collide(V (&g)[d3q19::directions], const CollisionConstants<T>& c) {
  if constexpr (form.central_moments)
    relax_central_moments<form.has_force>(g, c);
  else
    relax_halves<form.has_force>(g, c);
}

}  // namespace copepod::fluid
