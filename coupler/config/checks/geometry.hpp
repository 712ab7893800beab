#pragma once

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"

namespace copepod::coupler {

/// A vector given in the body's frame, in the world frame: R_WB v.
Eigen::Vector3d in_world(const BodySpecification& body, const Eigen::Vector3d& vector_B);

/// Unit vector of a body's own z axis (a capsule's axis) in the world frame.
Eigen::Vector3d body_axis(const BodySpecification& body);

/// Half of the body's extent along each world axis [m]: r + |d_i| L/2 for a capsule along d.
Eigen::Vector3d half_extents_m(const BodySpecification& body);

/// Distance between the surfaces of two bodies, B shifted by `shift_m` [m]; negative where they overlap.
double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                          const Eigen::Vector3d& shift_m);

/// All pairs (a, b), a < b, of bodies whose surfaces may be less than `reach_m` apart, and some more; sorted.
/// The bodies are put into the cells of a grid that their boxes touch, so the effort grows with their number
/// and not with its square.
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
std::vector<std::pair<std::size_t, std::size_t>> near_pairs(const std::vector<BodySpecification>& bodies,
                                                            const std::array<double, 3>& periodic_length_m,
                                                            double reach_m);

}  // namespace copepod::coupler
