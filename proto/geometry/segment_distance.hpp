#pragma once

#include <algorithm>

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

/// Place s ∈ [−1, 1] on a segment that is nearest to a point.
inline double nearest_place(const CoreSegment& segment, const Eigen::Vector3d& point_m) {
  const double squared_length_m2 = segment.half_W_m.squaredNorm();
  if (squared_length_m2 == 0.0) return 0.0;
  return std::clamp(segment.half_W_m.dot(point_m - segment.centre_W_m) / squared_length_m2, -1.0, 1.0);
}

/// The place s on the first of two segments that is nearest to the second. Source: Ericson, Real-Time Collision
/// Detection (2005), section 5.1.9. Segments may be points, parallel or crossing.
inline double nearest_place(const CoreSegment& first, const CoreSegment& second) {
  const Eigen::Vector3d& h1 = first.half_W_m;
  const Eigen::Vector3d& h2 = second.half_W_m;
  const Eigen::Vector3d d = second.centre_W_m - first.centre_W_m;

  // Nearest points of the two infinite lines; parallel lines have many, any of which serves as a start.
  const double a = h1.squaredNorm();
  const double b = h1.dot(h2);
  const double e = h2.squaredNorm();
  const double determinant = a * e - b * b;
  double s = 0.0;
  if (determinant > 1e-14 * a * e) s = std::clamp((e * h1.dot(d) - b * h2.dot(d)) / determinant, -1.0, 1.0);

  // The end of one segment may be nearest to an inner point of the other: project there and back.
  const double t = nearest_place(second, first.centre_W_m + s * h1);
  return nearest_place(first, second.centre_W_m + t * h2);
}

/// Shortest distance between two segments [m]: the points s, t ∈ [−1, 1] that minimise |c₂ + t h₂ − c₁ − s h₁|.
inline double segment_distance_m(const CoreSegment& first, const CoreSegment& second) {
  const Eigen::Vector3d point = first.centre_W_m + nearest_place(first, second) * first.half_W_m;
  return (point - second.centre_W_m - nearest_place(second, point) * second.half_W_m).norm();
}

}  // namespace copepod
