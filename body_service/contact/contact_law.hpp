#pragma once

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace copepod::body {

/// Restitution of a linear spring and dashpot of damping ratio ζ whose force is never attractive: the contact ends when
/// the force vanishes, before the overlap does,
///   e = exp(−2 ζ arccos ζ / √(1 − ζ²)),   ζ > 1: exp(−2 ζ arcosh ζ / √(ζ² − 1))                        (B21)
/// [Schwager & Pöschel, Granular Matter 9, 465, 2007]
inline double restitution_of(double damping_ratio) {
  const double z = damping_ratio;
  const double root = std::sqrt(std::abs(1.0 - z * z));
  if (root < 1e-6) return std::exp(-2.0);
  return std::exp(-2.0 * z * (z < 1.0 ? std::acos(z) : std::acosh(z)) / root);
}

/// Damping ratio with which contacts have that restitution.
/// @param restitution  in (0, 1]
inline double damping_ratio_of(double restitution) {
  double low = 0.0;  // weaker damping rebounds faster
  double high = 1.0;
  while (restitution_of(high) > restitution) high *= 2.0;
  for (int halving = 0; halving < 60; ++halving) {
    const double middle = 0.5 * (low + high);
    (restitution_of(middle) > restitution ? low : high) = middle;
  }
  return restitution == 1.0 ? 0.0 : 0.5 * (low + high);
}

/// Linear spring and dashpot along the normal, and across it limited by Coulomb friction.
struct ContactLaw {
  double stiffness_N_per_m = 0.0;
  double damping_ratio = 0.0;

  /// Share of the stiffness that a tangential spring has: with it spheres of uniform density, which also turn, swing
  /// across the normal as fast as along it.
  static constexpr double tangential = 2.0 / 7.0;

  /// c = 2 ζ √(m_eff k) [N s/m]
  [[nodiscard]] double damping_N_s_per_m(double mass_kg) const {
    return 2.0 * damping_ratio * std::sqrt(mass_kg * stiffness_N_per_m);
  }

  /// Mean normal force over an interval,
  ///   F = max(0, k δ + c u),   δ = overlap, u = dδ/dt                                                 (B20)
  /// for an overlap that changes linearly: where the contact begins or ends within the interval, only its part
  /// of it counts. The dashpot acts on the mean of the velocities before and after.
  /// @param overlap_m          in the middle of the interval
  /// @param approach_m_per_s   its rate of change
  /// @param mass_kg            effective mass of the contact
  [[nodiscard]] double normal_force_N(double overlap_m, double approach_m_per_s, double mass_kg,
                                      double duration_s) const {
    const double change_m = std::abs(approach_m_per_s) * duration_s;
    const double deepest_m = overlap_m + 0.5 * change_m;
    if (deepest_m <= 0.0) return 0.0;
    const bool whole = deepest_m >= change_m;
    const double part = whole ? 1.0 : deepest_m / change_m;
    const double mean_overlap_m = whole ? overlap_m : 0.5 * part * deepest_m;
    const double damping = part * damping_N_s_per_m(mass_kg);
    const double force_N = (stiffness_N_per_m * mean_overlap_m + damping * approach_m_per_s) /
                           (1.0 + 0.5 * damping * duration_s / mass_kg);
    return std::max(0.0, force_N);
  }

  /// Friction [Cundall & Strack, Géotechnique 29, 47, 1979] of a spring with memory,
  ///   F_t = −k_t s − c_t u_t,   |F_t| ≤ μ F;   sliding leaves s = −F_t/k_t                            (B23)
  /// @param stretch_m             s, already in the tangential plane; shortened where
  ///                              the contact slides
  /// @param slip_m_per_s          u_t, tangential velocity of the surface that feels the force, relative to the other
  [[nodiscard]] Eigen::Vector3d friction_N(Eigen::Vector3d& stretch_m, const Eigen::Vector3d& slip_m_per_s,
                                           double mass_kg, double limit_N) const {
    const double k = tangential * stiffness_N_per_m;
    Eigen::Vector3d force_N = -k * stretch_m - tangential * damping_N_s_per_m(mass_kg) * slip_m_per_s;
    const double size_N = force_N.norm();
    if (size_N <= limit_N) return force_N;
    force_N *= limit_N / size_N;
    stretch_m = -force_N / k;
    return force_N;
  }
};

/// The spring's stretch turned with the contact: projected on the plane normal to `normal`, its length kept.
inline Eigen::Vector3d turned_into_plane(const Eigen::Vector3d& stretch_m, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d projected_m = stretch_m - stretch_m.dot(normal) * normal;
  const double length_m = projected_m.norm();
  if (length_m == 0.0) return Eigen::Vector3d::Zero();
  return projected_m * (stretch_m.norm() / length_m);
}

}  // namespace copepod::body
