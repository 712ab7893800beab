#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "geometry/neighbour_grid.hpp"
#include "geometry/periodic_images.hpp"
#include "geometry/rotation.hpp"
#include "geometry/segment_distance.hpp"

namespace copepod::coupler {

/// Vector in the world frame: R_WB v.
/// @param vector_B  in the body's frame
inline Eigen::Vector3d in_world(const BodySpecification& body, const Eigen::Vector3d& vector_B) {
  return rotation_matrix(body.orientation_wxyz) * vector_B;
}

/// Unit vector of a body's own z axis (a capsule's axis) in the world frame.
inline Eigen::Vector3d body_axis(const BodySpecification& body) { return z_axis(body.orientation_wxyz); }

/// Half of the body's extent along each world axis [m]: r + |d_i| L/2 for a capsule along d.
inline Eigen::Vector3d half_extents_m(const BodySpecification& body) {
  return Eigen::Vector3d::Constant(body.shape.radius_m) + core_half_length_m(body.shape) * body_axis(body).cwiseAbs();
}

/// Distance between the surfaces of two bodies, B shifted by `shift_m` [m]; negative where they overlap.
inline double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                                 const Eigen::Vector3d& shift_m) {
  const CoreSegment first{A.position_m, core_half_length_m(A.shape) * body_axis(A)};
  const CoreSegment second{B.position_m + shift_m, core_half_length_m(B.shape) * body_axis(B)};
  return segment_distance_m(first, second) - A.shape.radius_m - B.shape.radius_m;
}

/// The least over all periodic images, as far as it is less than `reach_m`; otherwise more than that.
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
inline double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                                 const std::array<double, 3>& periodic_length_m, double reach_m) {
  const CoreSegment first{A.position_m, core_half_length_m(A.shape) * body_axis(A)};
  const CoreSegment second{B.position_m, core_half_length_m(B.shape) * body_axis(B)};
  const double bounds_m = bounding_radius_m(A.shape) + bounding_radius_m(B.shape);
  return PeriodicImages{periodic_length_m}.smallest_distance_m(first, second, bounds_m + reach_m) - A.shape.radius_m -
         B.shape.radius_m;
}

/// All pairs of bodies whose surfaces may be less than `reach_m` apart, and some more; ascending.
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
inline std::vector<BodyPair> near_pairs(const std::vector<BodySpecification>& bodies,
                                        const std::array<double, 3>& periodic_length_m, double reach_m) {
  constexpr double smallest_m = 1e-100;  // a case may contain any number: where products of lengths are finite
  constexpr double largest_m = 1e100;
  std::vector<double> radius_m;
  Eigen::Matrix3Xd centre_m(3, static_cast<Eigen::Index>(bodies.size()));
  for (const BodySpecification& body : bodies) {
    centre_m.col(static_cast<Eigen::Index>(radius_m.size())) = body.position_m;
    radius_m.push_back(std::clamp(bounding_radius_m(body.shape) + 0.5 * reach_m, smallest_m, largest_m));
  }
  std::vector<BodyPair> pairs;
  NeighbourGrid(std::move(radius_m), periodic_length_m).find_pairs(centre_m, pairs);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace copepod::coupler
