#include "model/mass_properties.hpp"

#include <numbers>

namespace copepod::body {

namespace {

double spherical_volume_m3(double radius_m) {
  return 4.0 / 3.0 * std::numbers::pi * radius_m * radius_m * radius_m;
}

double cylindrical_volume_m3(const Shape& shape) {
  return std::numbers::pi * shape.radius_m * shape.radius_m * 2.0 * core_half_length_m(shape);
}

}  // namespace

double volume_m3(const Shape& shape) {
  return cylindrical_volume_m3(shape) + spherical_volume_m3(shape.radius_m);
}

MassProperties mass_properties(const Shape& shape, double mass_kg) {
  const double radius = shape.radius_m;
  const double length = 2.0 * core_half_length_m(shape);
  const double volume = volume_m3(shape);
  const double cylinder_kg = mass_kg * (cylindrical_volume_m3(shape) / volume);
  const double half_spheres_kg = mass_kg * (spherical_volume_m3(radius) / volume);

  const double axial = cylinder_kg * radius * radius / 2.0 + half_spheres_kg * 0.4 * radius * radius;
  const double transverse =
      cylinder_kg * (length * length / 12.0 + radius * radius / 4.0) +
      half_spheres_kg * (0.4 * radius * radius + 0.375 * length * radius + length * length / 4.0);
  return {volume, Eigen::Vector3d(transverse, transverse, axial).asDiagonal()};
}

}  // namespace copepod::body
