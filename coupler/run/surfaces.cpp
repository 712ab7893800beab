#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <vector>

#include <nlohmann/json.hpp>

#include "config/sections/case.hpp"
#include "geometry/shapes/solid.hpp"
#include "run/program.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// Closed surface of triangles, as pages draw it: points in the shape's frame are multiples of `unit_m`. Only spheres
/// and capsules have a radius.
ordered_json surface_of(const Shape& shape, int around) {
  constexpr std::size_t most_triangles = 20'000;
  const auto solid = make_solid(shape);
  const Surface surface = solid->surface(around);
  const double unit_m = solid->bounding_radius() / (surface.strip.size() > 3 * most_triangles ? 50.0 : 10'000.0);
  std::map<std::array<long, 3>, int> numbers;
  std::vector<long> points;
  const auto number_of = [&](std::int32_t point) {
    const auto multiple = [&](int axis) { return std::lround(surface.points(axis, point) / unit_m); };
    const std::array place{multiple(0), multiple(1), multiple(2)};
    const auto [entry, is_new] = numbers.try_emplace(place, static_cast<int>(numbers.size()));
    if (is_new) points.insert(points.end(), place.begin(), place.end());
    return entry->second;
  };
  std::vector<int> triangles;
  surface.for_each_triangle([&](std::int32_t a, std::int32_t b, std::int32_t c) {
    const std::array corners{number_of(a), number_of(b), number_of(c)};
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      triangles.insert(triangles.end(), corners.begin(), corners.end());
  });
  const ordered_json radius_m = is_round(shape) ? ordered_json(shape.radius_m) : ordered_json(nullptr);
  return {{"radius_m", radius_m}, {"unit_m", unit_m}, {"points", points}, {"triangles", triangles}};
}

}  // namespace

ordered_json surfaces_of(const LoadedCase& loaded) {
  const std::vector<BodySpecification>& bodies = loaded.assembly.bodies;
  const int around = bodies.size() <= 30 ? 40 : 12;
  ordered_json surfaces = ordered_json::array();
  std::map<std::tuple<ShapeKind, double, double, double, double, double>, std::size_t> numbers;
  const auto number_of = [&](const Shape& shape) {
    const Eigen::Vector3d& extents_m = shape.extents_m;
    if (shape.mesh != nullptr || !shape.parts.empty()) {
      surfaces.push_back(surface_of(shape, around));
      return surfaces.size() - 1;
    }
    const auto [entry, is_new] = numbers.try_emplace(
        {shape.kind, shape.radius_m, shape.length_m, extents_m[0], extents_m[1], extents_m[2]}, surfaces.size());
    if (is_new) surfaces.push_back(surface_of(shape, around));
    return entry->second;
  };
  ordered_json by_body = ordered_json::object();
  for (const BodySpecification& body : bodies) by_body[body.name] = number_of(body.shape);
  ordered_json obstacles = ordered_json::array();
  for (const ObstacleSpecification& obstacle : loaded.content.fluid.obstacles)
    obstacles.push_back({{"surface", number_of(obstacle.shape)},
                         {"position_m", obstacle.position_m},
                         {"orientation_wxyz", obstacle.orientation_wxyz}});
  return {{"surfaces", surfaces}, {"bodies", by_body}, {"obstacles", obstacles}};
}

}  // namespace copepod::coupler
