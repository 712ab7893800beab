#include <algorithm>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "contract/shape.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod {

namespace {

double spherical_volume_m3(const Shape& shape) {
  return 4.0 / 3.0 * std::numbers::pi * shape.radius_m * shape.radius_m * shape.radius_m;
}

double cylindrical_volume_m3(const Shape& shape) {
  const double length_m = shape.kind == ShapeKind::cylinder ? shape.length_m : 2.0 * core_half_length_m(shape);
  return std::numbers::pi * shape.radius_m * shape.radius_m * length_m;
}

}  // namespace

double bounding_radius_m(const Shape& shape) {
  if (is_round(shape)) return core_half_length_m(shape) + shape.radius_m;
  if (shape.kind == ShapeKind::mesh) return shape.mesh->bounding_radius_m;
  if (shape.kind == ShapeKind::ellipsoid) return shape.extents_m.maxCoeff();
  if (shape.kind == ShapeKind::box) return 0.5 * shape.extents_m.norm();
  if (shape.kind == ShapeKind::cylinder) return std::hypot(shape.radius_m, 0.5 * shape.length_m);
  double radius_m = 0.0;
  for (const ShapePart& part : shape.parts)
    radius_m = std::max(radius_m, part.position_m.norm() + bounding_radius_m(part.shape));
  return radius_m;
}

double volume_m3(const Shape& shape) {
  return cylindrical_volume_m3(shape) + (shape.kind == ShapeKind::cylinder ? 0.0 : spherical_volume_m3(shape));
}

double thickness_m(const Shape& shape) {
  if (is_round(shape)) return 2.0 * shape.radius_m;
  if (shape.kind == ShapeKind::compound) {
    double thinnest_m = 2.0 * bounding_radius_m(shape);
    for (const ShapePart& part : shape.parts) thinnest_m = std::min(thinnest_m, thickness_m(part.shape));
    return thinnest_m;
  }
  const auto solid = make_solid(shape);
  const Surface surface = solid->surface(32);
  constexpr std::size_t most_tests = 20'000'000;  // of a line with a triangle
  const std::size_t every = 1 + surface.strip.size() * surface.strip.size() / most_tests;
  std::vector<std::pair<double, double>> ways;  // length, area
  double whole = 0.0;
  Intervals inside;
  const auto add_way = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
    const Eigen::Vector3d first = surface.points.col(a);
    const Eigen::Vector3d to_second = surface.points.col(b) - first;
    const Eigen::Vector3d to_third = surface.points.col(c) - first;
    const Eigen::Vector3d normal = to_second.cross(to_third);
    const double area = normal.norm();
    if (area == 0.0) return;
    solid->crossings(first + (to_second + to_third) / 3.0, -normal / area, inside);
    const auto way = std::ranges::min_element(inside, {}, [](const Interval& part) { return std::abs(part.low); });
    if (way == inside.end()) return;
    ways.emplace_back(way->high, area);
    whole += area;
  };
  surface.for_each_triangle(add_way, every);
  std::ranges::sort(ways);
  for (double thinner = 0.0; const auto& [length_m, area] : ways)
    if ((thinner += area) >= 0.25 * whole) return length_m;
  return 0.0;
}

Eigen::Matrix3d inertia_tensor_kg_m2(const Shape& shape, double mass_kg) {
  if (!is_round(shape)) {
    const VolumeMoments moments = make_solid(shape)->moments();
    return mass_kg / moments.volume * moments.inertia();
  }
  const double radius = shape.radius_m;
  const double length = 2.0 * core_half_length_m(shape);
  const double volume = volume_m3(shape);
  const double cylinder_kg = mass_kg * (cylindrical_volume_m3(shape) / volume);
  const double half_spheres_kg = mass_kg * (spherical_volume_m3(shape) / volume);
  const double along_kg_m2 = cylinder_kg * radius * radius / 2.0 + half_spheres_kg * 0.4 * radius * radius;
  const double across_kg_m2 =
      cylinder_kg * (length * length / 12.0 + radius * radius / 4.0) +
      half_spheres_kg * (0.4 * radius * radius + 0.375 * length * radius + length * length / 4.0);
  return Eigen::Vector3d(across_kg_m2, across_kg_m2, along_kg_m2).asDiagonal();
}

double largest_turning_per_kg(const BodySpecification& body) {
  const Eigen::Matrix3d inertia_kg_m2 = inertia_tensor_kg_m2(body);
  const double arm_m = core_half_length_m(body.shape);
  if (is_round(body.shape)) return arm_m * arm_m / std::min(inertia_kg_m2(0, 0), inertia_kg_m2(1, 1));
  const auto solid = make_solid(body.shape);
  const Surface surface = solid->surface(16);
  double largest = 0.0;
  for (Eigen::Index i = 0; i < surface.points.cols(); ++i) {
    const Eigen::Vector3d arm = Eigen::Vector3d(surface.points.col(i)).cross(Eigen::Vector3d(surface.normals.col(i)));
    largest = std::max(largest, arm.dot(inertia_kg_m2.ldlt().solve(arm)));
  }
  return largest;
}

}  // namespace copepod
