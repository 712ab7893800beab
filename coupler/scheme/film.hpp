#pragma once

#include <vector>

#include <Eigen/Core>

#include "geometry/near_surfaces.hpp"

namespace copepod::coupler {

/// What becomes of films as they get thin.
struct FilmLimits {
  double roughness_m = 0.0;     ///< they are taken to be at least as thick
  bool end_at_contact = false;  ///< surfaces that overlap are in contact, and only sliding and turning have a film
};

/// One piece of the thin film between two surfaces, and its resistances. With W and v the normal and the tangential
/// velocity at x, and Δω the angular velocity, of the first surface relative to the second, the first one feels
///   F = −Z W n − F_v v + F_ω n × Δω,   T = x × F − n × T_v v + n × T_ω (n × Δω) − T_n (n·Δω) n   [theory.md, (C20)]
/// and another body on the other side the opposite. F_v, F_ω, T_v, T_ω have a value along e and one across it.
struct FilmContact {
  Eigen::Vector3d point_m;                      ///< x, in the middle of the film
  Eigen::Vector3d normal;                       ///< n, from the second surface to the first
  double gap_m = 0.0;                           ///< between the surfaces; negative where they overlap
  double squeezing_N_s_per_m = 0.0;             ///< Z
  Eigen::Vector2d sliding_N_s_per_m{0, 0};      ///< F_v
  Eigen::Vector2d force_of_turning_N_s{0, 0};   ///< F_ω
  Eigen::Vector2d torque_of_sliding_N_s{0, 0};  ///< T_v
  Eigen::Vector2d turning_N_m_s{0, 0};          ///< T_ω
  double spinning_N_m_s = 0.0;                  ///< T_n
  Eigen::Vector3d along{0, 0, 0};               ///< e, a unit vector normal to n; zero where both values are the same

  /// W of a relative motion (V, Δω) about the origin.
  [[nodiscard]] double normal_velocity(const Eigen::Vector<double, 6>& motion) const;
  /// −∂(F, T)/∂(V, Δω): about the origin, with V the relative velocity there.
  [[nodiscard]] Eigen::Matrix<double, 6, 6> resistance() const;
};

/// Finds the films between a body and a surface near it, as far as the fluid does not resolve them. A sphere has one
/// piece, with the thickness h(ρ) = h₀ + ρ²/2R. So has an ellipsoid, with the curvatures where it is nearest. A capsule
/// has one at each end, as far as the half sphere is part of the film, and slices between them, with the thickness
/// h₀ + λx²/2 across the axis.
///
/// By Reynolds' equation the pressure is p = −(3 R W + 6/5 u·x) μ/h², of a slice −6μW/(λh²). With the share 1 − w of
/// the film that the fluid does not resolve,                                                     [theory.md, (C20)]
///   Z = 6π μ R [R I₂ + (1/5 + k₁k₂R²) I₁ + …],   F_v = 2π μ R [I₁ + 3/5 q² (L + o h₀ I₂) + …],
///   F_ω = 2π μ R² [6/5 (q L + o h₀ I₂) + …],   T_v = 2π μ R² [6/5 q L + …],   T_ω = 2π μ R³ [12/5 L + …],
///   T_n = 4π μ R² [I₀ − h₀ I₁ + …],   Iₙ = ∫ (1 − w) dh/hⁿ,   L = I₁ − h₀ I₂,   q = (k₁ − k₂)/(k₁ + k₂)
/// and R the radius of their mean curvature; o = 0 between bodies, 1 at walls and mirrors. Sharply cut off, I₂ is the
/// usual 1/h₀ − 1/h_c. I₁ beside it is the next term of the exact series [Brenner, Chem. Eng. Sci. 16, 1961; Jeffrey &
/// Onishi, J. Fluid Mech. 139, 1984]. The terms left out here are what the fluid around the film lacks, since no cells
/// take up what flows out of it, fitted to the exact loads of spheres [docs/decisions/lubrication.md].
/// @param first     of the body, in the frame of `second`: relative to the body's centre
/// @param contacts  overwritten
void find_film(const NearSurface& first, const NearSurface& second, const FilmRange& range, double viscosity_Pa_s,
               const FilmLimits& limits, std::vector<FilmContact>& contacts);

}  // namespace copepod::coupler
