#include "observers/surface_mesh.hpp"

#include <map>
#include <numbers>
#include <set>
#include <utility>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

const Shape meshed_sphere{ShapeKind::sphere, 2.0, 0.0};
const Shape meshed_capsule{ShapeKind::capsule, 2.0, 3.0};

/// Corners of the triangles that have an area, fronts outwards.
std::vector<std::array<std::int32_t, 3>> triangles(const SurfaceMesh& mesh) {
  std::vector<std::array<std::int32_t, 3>> result;
  for (std::size_t i = 0; i + 2 < mesh.strip.size(); ++i) {
    const std::int32_t a = mesh.strip[i], b = mesh.strip[i + 1], c = mesh.strip[i + 2];
    if (a == b || b == c || a == c) continue;
    result.push_back(i % 2 == 0 ? std::array{a, b, c} : std::array{b, a, c});
  }
  return result;
}

TEST(SurfaceMesh, IsClosedAndFacesOutwards) {
  for (const Shape& shape : {meshed_sphere, meshed_capsule}) {
    const SurfaceMesh mesh = surface_mesh(shape, 48);
    std::map<std::pair<int, int>, int> edges;
    double volume = 0.0;
    for (const auto& [a, b, c] : triangles(mesh)) {
      for (const auto& edge : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) ++edges[edge];
      volume += mesh.points_m.col(a).dot(mesh.points_m.col(b).cross(mesh.points_m.col(c))) / 6.0;
    }
    for (const auto& [edge, times] : edges) {
      EXPECT_EQ(times, 1);
      EXPECT_EQ(edges.count({edge.second, edge.first}), 1U) << "each edge once in either direction";
    }
    EXPECT_NEAR(volume / volume_m3(shape), 1.0, 0.01) << "inscribed, and nearly filling the shape";
  }
}

TEST(SurfaceMesh, LiesOnTheShapeWithItsAxisAlongZ) {
  const SurfaceMesh mesh = surface_mesh(meshed_capsule, 12);
  for (Eigen::Index i = 0; i < mesh.points_m.cols(); ++i) {
    const Eigen::Vector3d point = mesh.points_m.col(i);
    const Eigen::Vector3d core{0, 0, std::clamp(point.z(), -1.5, 1.5)};
    EXPECT_NEAR((point - core).norm(), 2.0, 1e-12);
    EXPECT_TRUE(mesh.normals.col(i).isApprox((point - core) / 2.0, 1e-12));
  }
  EXPECT_EQ(mesh.points_m.row(2).maxCoeff(), 3.5);
  EXPECT_NEAR(mesh.points_m.row(2).minCoeff(), -3.5, 1e-15);
}

TEST(SurfaceMesh, HasFewerPointsForASphereThanForACapsule) {
  EXPECT_EQ(surface_mesh(meshed_sphere, 12).points_m.cols(), 2 + 5 * 12);
  EXPECT_EQ(surface_mesh(meshed_capsule, 12).points_m.cols(), 2 + 6 * 12);
}

}  // namespace
}  // namespace copepod::coupler
