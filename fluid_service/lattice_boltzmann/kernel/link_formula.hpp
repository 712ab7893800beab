#pragma once

#include <algorithm>
#include <cmath>

#include "lattice_boltzmann/kernel/collision.hpp"

// Link formulas: what a body's surface sends back along a link. Each has `returning`, f_ᾱ(x_f, t + 1) − w_ᾱ;
// make_momentum_exchange picks the one named in the case.

namespace copepod::fluid {

/// A link from a fluid cell x_f in direction α into a body, lattice units; populations are deviations f − w. `V` is a
/// number, or a SIMD pack of them: one link each.
template <class V>
struct Link {
  V e[3]{};           ///< e_α
  V weight{};         ///< w_α
  V leaving{};        ///< f̃_α(x_f)
  V density{};        ///< ρ_w, that of the fluid cell
  V e_dot_u_w{};      ///< e_α·u_w
  V wall_distance{};  ///< q: the surface is at x_f + q e_α
  V inward{};         ///< f̃_ᾱ(x_f), which leaves for the second cell
  V behind{};         ///< f̃_α(x_f − e_α), which the second cell sends
  V e_dot_j{};        ///< e_α·j, j the momentum of x_f
};

/// Largest excess density that the flow itself can have beside a surface: at Mach 0.3, ρ' is 0.05. Beyond it fluid is
/// squeezed between surfaces that leave it no way out (or sucked, where they part).
constexpr double largest_excess_density = 0.1;

/// w_α ρ_w e_α·u_w, by which a moving surface acts in every formula.
template <class V>
[[gnu::always_inline]] inline V wall_term(const Link<V>& link) {
  return link.weight * link.density * link.e_dot_u_w;
}

/// What a formula needs, and does, beyond bounce-back.
struct LinkFormula {
  static constexpr bool uses_wall_distance = true;  ///< reads q, which costs a square root per link
  static constexpr bool uses_second_cell = true;    ///< reads f̃_α(x_f − e_α)
  /// With the Galilean invariant momentum exchange [Wen et al. 2014] and conservation of mass.
  static constexpr bool conserving = true;
};

/// Moving bounce-back [paper, section 2.3; Ladd 1994], as if the surface were half-way, q = 1/2:
///   f_ᾱ(x_f) = f̃_α(x_f) − 6 w_α ρ_w e_α·u_w
struct BounceBack {
  static constexpr bool uses_wall_distance = false;
  static constexpr bool uses_second_cell = false;
  static constexpr bool conserving = false;

  template <class V>
  [[gnu::always_inline]] static V returning(const Link<V>& link) {
    return link.leaving - 6.0 * link.weight * link.density * link.e_dot_u_w;
  }
};

/// Linear interpolation before or after the reflection [Bouzidi, Firdaouss, Lallemand 2001]:
///   q < 1/2:  f_ᾱ(x_f) = 2q f̃_α(x_f) + (1 − 2q) f̃_α(x_f − e_α) − 6 w_α ρ_w e_α·u_w
///   q ≥ 1/2:  f_ᾱ(x_f) = [f̃_α(x_f) + (2q − 1) f̃_ᾱ(x_f) − 6 w_α ρ_w e_α·u_w] / 2q
struct Interpolated : LinkFormula {
  template <class V>
  [[gnu::always_inline]] static V returning(const Link<V>& link) {
    const V twice = 2.0 * link.wall_distance;
    const V before = twice * link.leaving + (1.0 - twice) * link.behind - 6.0 * wall_term(link);
    const V after = (link.leaving + (twice - 1.0) * link.inward - 6.0 * wall_term(link)) / twice;
    return twice < 1.0 ? before : after;
  }
};

/// Central linear interpolation [Ginzburg, Verhaeghe, d'Humières 2008], with TRT at the same place for every τ:
///   f_ᾱ(x_f) = f̃_α(x_f) + (1 − 2q)/(1 + 2q) [f̃_α(x_f − e_α) − f̃_ᾱ(x_f)] − 12/(1 + 2q) w_α ρ_w e_α·u_w
struct CentralLinear : LinkFormula {
  template <class V>
  [[gnu::always_inline]] static V returning(const Link<V>& link) {
    const V scale = 1.0 / (1.0 + 2.0 * link.wall_distance);
    const V weight = (1.0 - 2.0 * link.wall_distance) * scale;
    return link.leaving + weight * (link.behind - link.inward) - 12.0 * scale * wall_term(link);
  }
};

/// Parabolic interpolation. In a steady flow the odd half of a pair, f⁻ = (f_α − f_ᾱ)/2, changes by −X in a collision
/// and by X on the way to the next one. With e = 3 w_α e_α·j, S = 3 w_α e_α·F, Λ⁺ = τ⁺ − 1/2 and ∂ the derivative along
/// the link, the Chapman–Enskog expansion gives
///   X + S = (f̃⁻ − e)/(τ⁻ − 1) = Λ⁺ ∂²e − ∂(w_α ρ) + S,   ∂e = f̃_α(x_f) − f̃_α(x_f − e_α) + X
/// The odd half remains as it is, but for a part of what is missing at the surface, r:
///   r = e − S/2 + q ∂e + q²/2 (X + S)/Λ⁺ − 3 w_α ρ_w e_α·u_w
///   f_ᾱ(x_f) = f̃_α(x_f − e_α) − 2 (f̃⁻ + X) + 4 k/(1 + 2q) r,   k as below
/// The steady state has r = 0 at every τ: a parabola through the surface, but for the gradient of pressure in X + S. Of
/// the kind of [Marson et al. 2021; Ginzburg et al. 2023], without a state of its own. With k = 1 staggered momentum,
/// (−1)^(x+t) j_x, which collisions conserve, would leave a surface as it came; so it would, reversed, with 1/2. Within
/// 0.02 of τ⁻ = 1 the collision leaves nothing of f⁻ − e, and X + S is taken as 0.
/// Of a deviation of f⁻ from e a surface at q = 1 returns −2 + 4/3 k (1 + 1/(2Λ⁺τ⁻)) parts, at most 2 if it is not to
/// grow from step to step. Hence k = min(τ⁺, 0.95, max(1/2, g/(1 + 1/(2Λ⁺τ⁻)))), with g = 2.75 where 3 is the limit.
/// With trt, Λ⁺τ⁻ > 3/16, k is min(τ⁺, 0.95). With bgk it is smaller for τ < 0.8, and below τ = 2/3, where k = 1/2
/// returns too much, 9 τ⁻ takes the place of 1/Λ⁺: part of the curvature is missing.
class Parabolic : public LinkFormula {
 public:
  template <class T>
  explicit Parabolic(const CollisionConstants<T>& c)
      : force_{c.force[0], c.force[1], c.force[2]},
        per_odd_(std::abs(odd_time(c) - 1.0) < 0.02 ? 0.0 : 1.0 / (odd_time(c) - 1.0)),
        per_even_(std::min(1.0 / (2.0 * even_time(c) - 1.0), (stable_gain / least_share - 1.0) * odd_time(c))),
        share_(4.0 *
               std::min({even_time(c), 0.95, std::max(least_share, stable_gain / (1.0 + per_even_ / odd_time(c)))})) {}

  template <class V>
  [[gnu::always_inline]] [[nodiscard]] V returning(const Link<V>& link) const {
    const V q = link.wall_distance;
    const V thrice_w = 3.0 * link.weight;
    const V odd_equilibrium = thrice_w * link.e_dot_j;
    const V source = thrice_w * (link.e[0] * force_[0] + link.e[1] * force_[1] + link.e[2] * force_[2]);
    const V odd = 0.5 * (link.leaving - link.inward);
    const V change_and_source = (odd - odd_equilibrium) * per_odd_;
    const V change = change_and_source - source;
    const V missing = odd_equilibrium - 0.5 * source + q * (link.leaving - link.behind + change) +
                      q * q * per_even_ * change_and_source - 3.0 * wall_term(link);
    return link.behind - 2.0 * (odd + change) + share_ / (1.0 + 2.0 * q) * missing;
  }

 private:
  static constexpr double stable_gain = 2.75;  ///< g
  static constexpr double least_share = 0.5;   ///< of k
  double force_[3];
  double per_odd_;   ///< 1/(τ⁻ − 1), or 0
  double per_even_;  ///< 1/(2 Λ⁺), or what is stable
  double share_;     ///< 4 k
};

}  // namespace copepod::fluid
