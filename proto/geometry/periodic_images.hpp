#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include "geometry/segment_distance.hpp"

namespace copepod {

/// The images of a periodic domain. What is near a body there, films, contacts and overlaps alike, comes from here.
struct PeriodicImages {
  std::array<double, 3> length_m{};  ///< 0: that direction is not periodic

  /// Vector between the nearest images of two points [m].
  [[nodiscard]] Eigen::Vector3d nearest_m(Eigen::Vector3d difference_m) const {
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double length = length_m[axis];
      if (length > 0.0) difference_m[axis] -= length * std::round(difference_m[axis] / length);
    }
    return difference_m;
  }

  /// Calls act(place_m, number) for every image of a point nearer than `reach_m` to the origin, in ascending order of
  /// its number:  place = point + number · length. Images more than three lengths away, or of points so far out
  /// that images do not differ in their last digits, are left out.
  template <class Act>
  void for_each(const Eigen::Vector3d& point_m, double reach_m, const Act& act) const {
    Eigen::Vector3d first(0, 0, 0), last(0, 0, 0);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const double length = length_m[axis];
      if (!(length > 0.0)) continue;
      const double reach = std::min(reach_m, 3.0 * length);
      first[axis] = std::ceil((-reach - point_m[axis]) / length);
      last[axis] = std::min(std::floor((reach - point_m[axis]) / length), first[axis] + 6.0);
      if (!(std::abs(first[axis]) < 1e15)) return;
    }
    Eigen::Vector3d number;
    for (number[0] = first[0]; number[0] <= last[0]; ++number[0])
      for (number[1] = first[1]; number[1] <= last[1]; ++number[1])
        for (number[2] = first[2]; number[2] <= last[2]; ++number[2]) {
          const Eigen::Vector3d place_m =
              point_m + number.cwiseProduct(Eigen::Vector3d(length_m[0], length_m[1], length_m[2]));
          if (place_m.squaredNorm() < reach_m * reach_m) act(place_m, number);
        }
  }

  /// Smallest distance between two segments [m], over all images of the second whose centre is nearer than `reach_m` to
  /// that of the first; infinity if there is none.
  /// @param same  both are of one body, which is not an image of itself
  [[nodiscard]] double smallest_distance_m(const CoreSegment& first, const CoreSegment& second, double reach_m,
                                           bool same = false) const {
    double smallest_m = std::numeric_limits<double>::infinity();
    for_each(second.centre_W_m - first.centre_W_m, reach_m, [&](const Eigen::Vector3d& place_m, const auto& number) {
      if (same && number.isZero(0.0)) return;
      const CoreSegment own{Eigen::Vector3d::Zero(), first.half_W_m};
      smallest_m = std::min(smallest_m, segment_distance_m(own, {place_m, second.half_W_m}));
    });
    return smallest_m;
  }
};

}  // namespace copepod
