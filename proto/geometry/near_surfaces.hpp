#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_pairs.hpp"
#include "geometry/segment_distance.hpp"

namespace copepod {

/// Films between surfaces, by their thickness at a point: below `low_m` they are not resolved by the fluid's cells,
/// above `high_m` they are, between they are in part.
struct FilmRange {
  double low_m = 0.0;   ///< thickest film that is not resolved at all
  double high_m = 0.0;  ///< thinnest film that is resolved

  /// Half a cell to both sides of FluidSetup::film_thickness_m.
  explicit FilmRange(const FluidSetup& setup)
      : low_m(setup.film_thickness_m - 0.5 * setup.cell_size_m),
        high_m(setup.film_thickness_m + 0.5 * setup.cell_size_m) {}

  [[nodiscard]] double resolved_share(double thickness_m) const {
    return std::clamp((thickness_m - low_m) / (high_m - low_m), 0.0, 1.0);
  }  ///< of a film of this thickness, from 0 to 1
};

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

/// A surface near a body, relative to that body's centre: of another body, of the image of a body through a periodic
/// face or mirrors, or of a wall.
struct NearSurface {
  int other = -1;                                               ///< the body whose surface or image it is; −1: a wall
  std::array<bool, 3> mirrored{};                               ///< the image: axes along which it is mirrored
  CoreSegment core{};                                           ///< of a body
  double radius_m = 0.0;                                        ///< of a sphere or capsule
  Eigen::Matrix3d squares_m2 = Eigen::Matrix3d::Zero().eval();  ///< of an ellipsoid: S, see SmoothSurface
  Eigen::Matrix3d inverse_per_m2 = squares_m2;                  ///< S⁻¹
  double stretch = 1.0;               ///< true distances are at most so many times those of from()
  int face = -1;                      ///< of a wall: its place in FluidSetup::boundaries
  Eigen::Vector3d normal{0, 0, 0};    ///< of a wall: unit vector into the fluid; else towards the body's centre
  double distance_of_centre_m = 0.0;  ///< of the body from the plane with this normal that touches the surface

  [[nodiscard]] bool is_body() const { return other >= 0; }                                       ///< else a wall
  [[nodiscard]] bool is_ellipsoid() const { return squares_m2(0, 0) > 0.0; }                      ///< of a body
  [[nodiscard]] SmoothSurface smooth() const { return {core.centre_W_m, radius_m, squares_m2}; }  ///< unless a capsule
  [[nodiscard]] bool is_mirrored() const { return mirrored != std::array<bool, 3>{}; }            ///< in a mirror
  /// From that plane to a point, relative to the body's centre [m]. No point is nearer to the surface.
  [[nodiscard]] double beyond_plane_m(const Eigen::Vector3d& point_m) const {
    return distance_of_centre_m + normal.dot(point_m);
  }

  /// From the surface, with the direction in which it is.
  struct Distance {
    double m = 0.0;          ///< in metres
    Eigen::Vector3d normal;  ///< of the surface; the plane with it that touches the surface is so far from the point
  };
  /// From the surface to a point outside, relative to the body's centre. Exact but for ellipsoids, and there where the
  /// surface is near: (s − 1) s/|S⁻¹p|, s = √(pᵀS⁻¹p), p from the ellipsoid's centre.
  [[nodiscard]] Distance from(const Eigen::Vector3d& point_m) const {
    if (!is_body()) return {beyond_plane_m(point_m), normal};
    const Eigen::Vector3d p = point_m - core.centre_W_m;
    if (!is_ellipsoid()) {
      const Eigen::Vector3d away_m = p - nearest_place(core, point_m) * core.half_W_m;
      const double distance_m = away_m.norm();
      return {distance_m - radius_m, away_m / distance_m};
    }
    const Eigen::Vector3d along = inverse_per_m2 * p;
    const double s = std::sqrt(p.dot(along)), slope = along.norm();
    return {(s - 1.0) * s / slope, along / slope};
  }
};

/// The surfaces that are near each body of a fluid: of others, of all their images through periodic faces and in
/// mirrors, of its own images, and of walls. Mirrors are symmetry planes and faces with free slip. Two bodies that a
/// joint holds in touch, or lets overlap, are not near each other. Only shapes between which films are known have such
/// surfaces (have_films).
class NearSurfaces {
 public:
  /// @param reach_m  surfaces that are further apart are left out
  NearSurfaces(const FluidSetup& setup, double reach_m);

  /// @param kinematics  finite; bodies in the order of the setup
  void find(const Kinematics& kinematics);

  /// Bodies by ascending number, then walls by face.
  [[nodiscard]] const std::vector<NearSurface>& of_body(std::size_t body) const { return surfaces_[body]; }

  /// The body's own surface, in the world.
  [[nodiscard]] const NearSurface& surface_of(std::size_t body) const { return own_[body]; }

 private:
  [[nodiscard]] NearSurface placed(int body, const Kinematics& kinematics) const;
  void add_images(int body, int other);
  void add_walls(int body);

  FluidSetup setup_;
  double reach_m_;
  Eigen::Vector3d length_m_;
  double shortest_period_m_ = std::numeric_limits<double>::infinity();
  std::array<bool, 6> mirror_{};  ///< by face
  NearPairs near_pairs_;
  std::vector<NearSurface> own_;
  std::vector<std::vector<NearSurface>> surfaces_;
};

}  // namespace copepod
