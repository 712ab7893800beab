#pragma once

#include <Eigen/Core>

#include "contract/shape.hpp"

namespace copepod::body {

/// Volume and inertia of a rigid body of uniform density, about its centre of mass, in its own frame.
struct MassProperties {
  double volume_m3 = 0.0;
  Eigen::Matrix3d inertia_kg_m2 =
      Eigen::Matrix3d::Zero();  ///< tensor I_B; the shape axis is the body's z axis
};

/// Volume of a shape [m³]: sphere and capsule, eqs. (B1) and (B3) of docs/theory_bodies.md.
double volume_m3(const Shape& shape);

/// Mass properties of a shape that is filled uniformly.
///   sphere:   V = 4/3 π r³,          I = 2/5 m r² 1                                   (B1), (B2)
///   capsule:  V = π r² l + 4/3 π r³, m_c and m_s the masses of cylinder and half spheres  (B3)
///             I_axial      = m_c r²/2 + 2/5 m_s r²                                      (B4)
///             I_transverse = m_c (l²/12 + r²/4) + m_s (2/5 r² + 3/8 l r + l²/4)         (B5)
/// @param mass_kg  positive
MassProperties mass_properties(const Shape& shape, double mass_kg);

/// Half the length of the shape's core segment [m]: the shape is all points within `radius_m` of it. 0 for a
/// sphere.
inline double core_half_length_m(const Shape& shape) {
  return shape.kind == ShapeKind::capsule ? 0.5 * shape.length_m : 0.0;
}

/// Radius of the smallest sphere around the centre of mass that holds the shape [m].
inline double bounding_radius_m(const Shape& shape) { return core_half_length_m(shape) + shape.radius_m; }

}  // namespace copepod::body
