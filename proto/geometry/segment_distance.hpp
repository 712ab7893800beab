#pragma once

#include <Eigen/Core>

#include "contract/shape.hpp"
#include "geometry/rotation.hpp"

namespace copepod {

/// Core of a sphere or capsule: all points within the radius of this segment belong to the body.
struct CoreSegment {
  Eigen::Vector3d centre_W_m;  ///< world frame
  Eigen::Vector3d half_W_m;    ///< from the centre to one end; zero for a sphere
};

/// @param position_m, orientation_wxyz  of all bodies; those of number `body` count, whose shape is a sphere or capsule
inline CoreSegment core_of(const Shape& shape, Eigen::Index body, const auto& position_m,
                           const auto& orientation_wxyz) {
  const double half_length_m = core_half_length_m(shape);
  if (half_length_m == 0.0) return {position_m.col(body), Eigen::Vector3d::Zero()};
  return {position_m.col(body), half_length_m * z_axis(orientation_wxyz.col(body))};
}

/// Shortest distance between two segments [m]: the points s, t ∈ [−1, 1] that minimise |c₂ + t h₂ − c₁ − s h₁|. Source:
/// Ericson, Real-Time Collision Detection (2005), section 5.1.9. Segments may be points, parallel or crossing.
double segment_distance_m(const CoreSegment& first, const CoreSegment& second);

/// The place s ∈ [−1, 1] on the first of them.
double nearest_place(const CoreSegment& first, const CoreSegment& second);

}  // namespace copepod
