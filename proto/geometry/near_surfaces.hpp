#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include <Eigen/Core>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_pairs.hpp"
#include "geometry/segment_distance.hpp"
#include "geometry/smooth_surface.hpp"

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

/// A surface near a body, relative to that body's centre: of another body, of the image of a body through a periodic
/// face or mirrors, or of a wall.
struct NearSurface {
  int other = -1;                                               ///< the body whose surface or image it is; −1: a wall
  std::array<bool, 3> mirrored{};                               ///< the image: axes along which it is mirrored
  CoreSegment core{};                                           ///< of a body
  double radius_m = 0.0;                                        ///< of a sphere or capsule
  Eigen::Matrix3d squares_m2 = Eigen::Matrix3d::Zero().eval();  ///< of an ellipsoid, see SmoothSurface
  int face = -1;                                                ///< of a wall: its place in FluidSetup::boundaries
  Eigen::Vector3d normal{0, 0, 0};                              ///< of a wall: unit vector into the fluid
  double distance_of_centre_m = 0.0;                            ///< of a wall: from the body's centre

  [[nodiscard]] bool is_body() const { return other >= 0; }                                       ///< else a wall
  [[nodiscard]] bool is_ellipsoid() const { return squares_m2(0, 0) > 0.0; }                      ///< of a body
  [[nodiscard]] SmoothSurface smooth() const { return {core.centre_W_m, radius_m, squares_m2}; }  ///< unless a capsule
  [[nodiscard]] bool is_mirrored() const { return mirrored != std::array<bool, 3>{}; }            ///< in a mirror
  /// From a point, relative to the body's centre, to the surface [m].
  [[nodiscard]] double distance_m(const Eigen::Vector3d& point_m) const;
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
  [[nodiscard]] NearSurface surface_of(int body, const Kinematics& kinematics) const;

 private:
  void add_images(int body, int other, const Kinematics& kinematics);
  void add_walls(int body, const Kinematics& kinematics);

  FluidSetup setup_;
  double reach_m_;
  Eigen::Vector3d length_m_;
  double shortest_period_m_ = std::numeric_limits<double>::infinity();
  std::array<bool, 6> mirror_{};  ///< by face
  NearPairs near_pairs_;
  std::vector<std::vector<NearSurface>> surfaces_;
};

}  // namespace copepod
