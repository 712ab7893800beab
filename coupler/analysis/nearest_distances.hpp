#pragma once

#include <array>

#include <Eigen/Core>

namespace copepod::coupler {

/// Distance from each of several points to the nearest other one [m], in time linear in their number where they are
/// spread evenly: balls about the points grow until they meet another.
/// @param points_m           finite, shape (3, points ≥ 2)
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
Eigen::VectorXd nearest_distances_m(const Eigen::Matrix3Xd& points_m, const std::array<double, 3>& periodic_length_m);

}  // namespace copepod::coupler
