#pragma once

namespace copepod {

enum class ShapeKind { sphere, capsule };

/// Rigid shape in the body frame, centred at the centre of mass.
/// A capsule is a cylinder of `length_m` along the body's z axis, closed by two half spheres.
struct Shape {
  ShapeKind kind = ShapeKind::sphere;
  double radius_m = 0.0;
  double length_m = 0.0;  ///< cylinder part only; 0 for a sphere
};

}  // namespace copepod
