#pragma once

#include <Eigen/Core>

namespace copepod {

/// Surface of a sphere, an ellipsoid or a point: all that is `radius_m` away from (x − c)ᵀ S⁻¹ (x − c) = 1, with S the
/// squares of the semi-axes. Its support height in the direction n is √(nᵀ S n) + r.
struct SmoothSurface {
  Eigen::Vector3d centre_m{0, 0, 0};                            ///< c
  double radius_m = 0.0;                                        ///< r, of a sphere
  Eigen::Matrix3d squares_m2 = Eigen::Matrix3d::Zero().eval();  ///< S, of an ellipsoid, as it is turned

  /// The point with the normal n, a unit vector: c + S n/√(nᵀ S n) + r n
  [[nodiscard]] Eigen::Vector3d support_m(const Eigen::Vector3d& n) const;
  /// How that point moves when n turns: ∂x/∂n across n, whose inverse there are the curvatures.
  [[nodiscard]] Eigen::Matrix3d radii_m(const Eigen::Vector3d& n) const;
};

/// Where two surfaces are nearest to each other: at their points with the normals −n and n.
struct Separation {
  Eigen::Vector3d normal;  ///< n, from the second to the first
  double gap_m = 0.0;      ///< negative where they overlap, by the least way out
};

/// The n with the largest gap n·(c₁ − c₂) − h₁(n) − h₂(n), by Newton's method: with the points x₁(−n) and x₂(n) and
/// d = x₁ − x₂, it changes by (∂x₁/∂n + ∂x₂/∂n + n·d)⁻¹ d across n.
/// @param first, second  with centres that are apart
/// @param far_m          a gap that is not less is not improved: it is that or more
/// @param near_m         a gap that is certainly less is not improved either: it may be more than what is returned
Separation separation(const SmoothSurface& first, const SmoothSurface& second, double far_m, double near_m = 0.0);

}  // namespace copepod
