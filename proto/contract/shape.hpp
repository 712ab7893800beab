#pragma once

#include <numbers>
#include <utility>

namespace copepod {

using BodyPair = std::pair<int, int>;  ///< indices, the lower one first

enum class ShapeKind { sphere, capsule };

/// Rigid shape in the body frame, centred at the centre of mass.
/// A capsule is a cylinder of `length_m` along the body's z axis, closed by two half spheres.
struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  double radius_m = 0.0;
  double length_m = 0.0;  ///< cylinder part only; 0 for a sphere
};

/// Half the length of the shape's core segment [m]: the shape is all points within `radius_m` of it.
/// 0 for a sphere.
inline double core_half_length_m(const Shape& shape) {
  return shape.kind == ShapeKind::capsule ? 0.5 * shape.length_m : 0.0;
}

/// Radius of the smallest sphere around the centre of mass that contains the shape [m].
inline double bounding_radius_m(const Shape& shape) { return core_half_length_m(shape) + shape.radius_m; }

/// Volume of the two half spheres, 4/3 π r³.
inline double spherical_volume_m3(const Shape& shape) {
  return 4.0 / 3.0 * std::numbers::pi * shape.radius_m * shape.radius_m * shape.radius_m;
}

/// Volume of the cylinder, π r² l.
inline double cylindrical_volume_m3(const Shape& shape) {
  return std::numbers::pi * shape.radius_m * shape.radius_m * 2.0 * core_half_length_m(shape);
}

/// Volume of a shape: V = π r² l + 4/3 π r³                                               (B1), (B3)
/// [theory_bodies.md]
inline double volume_m3(const Shape& shape) { return cylindrical_volume_m3(shape) + spherical_volume_m3(shape); }

/// Moments of inertia about the centre of mass.
struct MomentsOfInertia {
  double along_kg_m2 = 0.0;   ///< about the shape's own axis, the body's z axis
  double across_kg_m2 = 0.0;  ///< about any axis perpendicular to it
};

/// Moments of inertia of a uniformly filled shape, m_c and m_s the masses of cylinder and half spheres:
///   I_along  = m_c r²/2 + 2/5 m_s r²                                                             (B2), (B4)
///   I_across = m_c (l²/12 + r²/4) + m_s (2/5 r² + 3/8 l r + l²/4)                                      (B5)
/// @param mass_kg  positive
inline MomentsOfInertia moments_of_inertia(const Shape& shape, double mass_kg) {
  const double radius = shape.radius_m;
  const double length = 2.0 * core_half_length_m(shape);
  const double volume = volume_m3(shape);
  const double cylinder_kg = mass_kg * (cylindrical_volume_m3(shape) / volume);
  const double half_spheres_kg = mass_kg * (spherical_volume_m3(shape) / volume);
  return {cylinder_kg * radius * radius / 2.0 + half_spheres_kg * 0.4 * radius * radius,
          cylinder_kg * (length * length / 12.0 + radius * radius / 4.0) +
              half_spheres_kg * (0.4 * radius * radius + 0.375 * length * radius + length * length / 4.0)};
}

}  // namespace copepod
