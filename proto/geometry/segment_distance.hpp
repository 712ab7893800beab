#pragma once

#include <Eigen/Core>

namespace copepod {

/// Core of a sphere or capsule: all points within the radius of this segment belong to the body.
struct CoreSegment {
  Eigen::Vector3d centre_W_m;  ///< world frame
  Eigen::Vector3d half_W_m;    ///< from the centre to one end; zero for a sphere
};

/// Shortest distance between two segments [m]: the points s, t ∈ [−1, 1] that minimise |c₂ + t h₂ − c₁ − s h₁|. Source:
/// Ericson, Real-Time Collision Detection (2005), section 5.1.9. Segments may be points, parallel or crossing.
double segment_distance_m(const CoreSegment& first, const CoreSegment& second);

/// The place s ∈ [−1, 1] on the first of them.
double nearest_place(const CoreSegment& first, const CoreSegment& second);

}  // namespace copepod
