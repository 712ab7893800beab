#pragma once

#include <Eigen/Core>

#include "contract/body_setup.hpp"

namespace copepod::coupler {

/// A vector given in the body's frame, in the world frame: R_WB v.
Eigen::Vector3d in_world(const BodySpecification& body, const Eigen::Vector3d& vector_B);

/// Unit vector of a body's own z axis (a capsule's axis) in the world frame.
Eigen::Vector3d body_axis(const BodySpecification& body);

/// Half of the body's extent along each world axis [m]: r + |d_i| L/2 for a capsule along d.
Eigen::Vector3d half_extents_m(const BodySpecification& body);

/// Volume [m³]: 4/3 π r³ + π r² L.
double volume_m3(const Shape& shape);

/// Moments of inertia of a homogeneous body about its centre.
struct Inertia {
  double along_kg_m2 = 0.0;   ///< about its own z axis
  double across_kg_m2 = 0.0;  ///< about any axis perpendicular to it
};
/// @return (B4), docs/theory_bodies.md
Inertia inertia_of(const Shape& shape, double mass_kg);

/// Distance between the surfaces of two bodies, B shifted by `shift_m` [m]; negative where they overlap.
double surface_distance_m(const BodySpecification& A, const BodySpecification& B,
                          const Eigen::Vector3d& shift_m);

}  // namespace copepod::coupler
