#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "geometry/neighbour_grid.hpp"
#include "geometry/periodic_images.hpp"
#include "geometry/rotation.hpp"
#include "geometry/segment_distance.hpp"
#include "geometry/shapes/overlaps.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {

/// Vector in the world frame: R_WB v.
/// @param vector_B  in the body's frame
inline Eigen::Vector3d in_world(const BodySpecification& body, const Eigen::Vector3d& vector_B) {
  return rotation_matrix(body.orientation_wxyz) * vector_B;
}

/// Unit vector of a body's own z axis (a capsule's axis) in the world frame.
inline Eigen::Vector3d body_axis(const BodySpecification& body) { return z_axis(body.orientation_wxyz); }

/// How far a body reaches from its centre in a direction, a unit vector [m].
inline double extent_m(const BodySpecification& body, const Eigen::Vector3d& direction) {
  const Eigen::Vector3d direction_B = rotation_matrix(body.orientation_wxyz).transpose() * direction;
  return make_solid(body.shape)->support(direction_B).dot(direction_B);
}

/// The larger of the two along each world axis [m]; r + |d_i| L/2 for a capsule along d.
inline Eigen::Vector3d half_extents_m(const BodySpecification& body) {
  if (is_round(body.shape))
    return Eigen::Vector3d::Constant(body.shape.radius_m) + core_half_length_m(body.shape) * body_axis(body).cwiseAbs();
  Eigen::Vector3d half_m;
  for (int axis = 0; axis < 3; ++axis)
    half_m[axis] = std::max(extent_m(body, Eigen::Vector3d::Unit(axis)), extent_m(body, -Eigen::Vector3d::Unit(axis)));
  return half_m;
}

/// Distance between the surfaces of two bodies, the least over all periodic images as far as it is less than `reach_m`,
/// otherwise more than that [m]; negative where they overlap. Of shapes that are not round a lower bound: the distance
/// along the line of the centres.
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
inline double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                                 const std::array<double, 3>& periodic_length_m, double reach_m) {
  const PeriodicImages images{periodic_length_m};
  const double bounds_m = bounding_radius_m(A.shape) + bounding_radius_m(B.shape);
  if (is_round(A.shape) && is_round(B.shape)) {
    const CoreSegment first{A.position_m, core_half_length_m(A.shape) * body_axis(A)};
    const CoreSegment second{B.position_m, core_half_length_m(B.shape) * body_axis(B)};
    return images.smallest_distance_m(first, second, bounds_m + reach_m) - A.shape.radius_m - B.shape.radius_m;
  }
  Eigen::Matrix3Xd position_m(3, 2);
  position_m << A.position_m, B.position_m;
  Eigen::Matrix4Xd orientation_wxyz(4, 2);
  orientation_wxyz << A.orientation_wxyz, B.orientation_wxyz;
  const double depth_m = Overlaps({A.shape, B.shape}, images).depth_m(0, 1, position_m, orientation_wxyz);
  if (depth_m > 0.0) return -depth_m;
  double nearest_m = 2.0 * reach_m;
  images.for_each(B.position_m - A.position_m, bounds_m + reach_m, [&](const Eigen::Vector3d& place_m, const auto&) {
    const Eigen::Vector3d along = place_m.stableNormalized();
    nearest_m = std::min(nearest_m, place_m.norm() - extent_m(A, along) - extent_m(B, -along));
  });
  return std::max(nearest_m, 0.0);
}

/// The same without images.
inline double surface_distance_m(const BodySpecification& A, const BodySpecification& B) {
  return surface_distance_m(A, B, std::array<double, 3>{}, (A.position_m - B.position_m).norm());
}

/// All pairs of bodies whose surfaces may be less than `reach_m` apart, and some more; ascending.
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
inline std::vector<BodyPair> near_pairs(const std::vector<BodySpecification>& bodies,
                                        const std::array<double, 3>& periodic_length_m, double reach_m) {
  constexpr double smallest_m = 1e-100;  // a case may contain any number: where products of lengths are finite
  constexpr double largest_m = 1e100;
  std::vector<double> radius_m;
  Eigen::Matrix3Xd centre_m(3, bodies.size());
  for (const BodySpecification& body : bodies) {
    centre_m.col(radius_m.size()) = body.position_m;
    radius_m.push_back(std::clamp(bounding_radius_m(body.shape) + 0.5 * reach_m, smallest_m, largest_m));
  }
  std::vector<BodyPair> pairs;
  NeighbourGrid(std::move(radius_m), periodic_length_m).find_pairs(centre_m, pairs);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace copepod::coupler
