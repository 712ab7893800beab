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

/// One piece of the thin film between two surfaces, and the resistances of lubrication theory. With W and v the normal
/// and the tangential velocity at x, and Δω the angular velocity, of the first surface relative to the second, the
/// first one feels                                                                             [theory.md, (C20)]
///   F = −Z W n − (1 + 3/5 q²) S v + 6/5 q R S n × Δω,   T = x × F − 6/5 q R S n × v + 12/5 R² D n × (n × Δω)
/// with q = (k₁ − k₂)/(k₁ + k₂) of the curvatures k of the surfaces, and the second one the opposite.
struct FilmContact {
  Eigen::Vector3d point_m;           ///< x, in the middle of the film
  Eigen::Vector3d normal;            ///< n, from the second surface to the first
  double gap_m = 0.0;                ///< between the surfaces; negative where they overlap
  double squeezing_N_s_per_m = 0.0;  ///< Z
  double shear_N_s_per_m = 0.0;      ///< S
  double turning_N_s_per_m = 0.0;    ///< D
  double radius_m = 0.0;             ///< R; 0: a slice of a cylinder, which has no D
  double contrast = 0.0;             ///< q

  /// W of a relative motion (V, Δω) about the origin.
  [[nodiscard]] double normal_velocity(const Eigen::Vector<double, 6>& motion) const;
  /// −∂(F, T)/∂(V, Δω): about the origin, with V the relative velocity there.
  [[nodiscard]] Eigen::Matrix<double, 6, 6> resistance() const;
};

/// Finds the films between a body and a surface near it, as far as the fluid does not resolve them. A sphere has one
/// piece, with the thickness h(ρ) = h₀ + ρ²/2R. A capsule has one at each end, as far as the half sphere is part of the
/// film, and slices between them, with the thickness h₀ + λx²/2 across the axis.
///
/// By Reynolds' equation the pressure is p = −(3 R W + 6/5 u·x) μ/h², of a slice −6μW/(λh²). With the share 1 − w of
/// the film that the fluid does not resolve,
///   Z = 6π μ R [R I₂ + (1/5 + k₁k₂R²) I₁ + 0.6 m],   S = 2π μ R [I₁ + 0.15 m],   D = S − π μ R h₀ I₂,
///   Iₙ = ∫ (1 − w) dh/hⁿ,   m = 1 − h₀/h_high
/// and R the radius of their mean curvature. Sharply cut off, I₂ is the usual 1/h₀ − 1/h_c. I₁ beside it is the next
/// term of the exact series [Brenner, Chem. Eng. Sci. 16, 1961; Jeffrey & Onishi, J. Fluid Mech. 139, 1984]; the terms
/// with m are what the fluid around the film lacks, since no cells take up what flows out of it, fitted to the exact
/// loads of spheres [docs/decisions/lubrication.md].
/// @param first     core of the body, radius `radius_m`; in the frame of `second`: relative to a body's centre
/// @param contacts  overwritten
void find_film(const CoreSegment& first, double radius_m, const NearSurface& second, const FilmRange& range,
               double viscosity_Pa_s, const FilmLimits& limits, std::vector<FilmContact>& contacts);

}  // namespace copepod::coupler
