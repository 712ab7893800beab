#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "contract/body_setup.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod {
namespace {

constexpr double pi = std::numbers::pi;

/// A solid with what is known of it by other means.
struct Known {
  const char* name;
  Shape shape;
  double volume;
  std::function<bool(const Eigen::Vector3d&)> is_inside;
  Eigen::Vector3d inertia;  ///< diagonal about the origin, for a density of 1; 0: not known
};

Shape box_of(const Eigen::Vector3d& edges) { return {.kind = ShapeKind::box, .extents_m = edges}; }

bool in_box(const Eigen::Vector3d& p, const Eigen::Vector3d& edges) {
  return (p.cwiseAbs() - 0.5 * edges).maxCoeff() < 0.0;
}

/// A tetrahedron within the cube of edge 2.
Shape tetrahedron() {
  Eigen::Matrix3Xd corners(3, 4);
  corners << 1, -1, -1, 1, 1, -1, 1, -1, 1, 1, -1, -1;
  TriangleMesh::Triangles triangles(3, 4);
  triangles << 0, 0, 0, 1, 2, 1, 3, 2, 1, 3, 2, 3;
  return {.kind = ShapeKind::mesh, .mesh = std::make_shared<const TriangleMesh>(corners, triangles)};
}

const std::vector<Known>& known_shapes() {
  const Eigen::Vector3d axes(1.0, 2.0, 3.0);
  const Eigen::Vector3d edges(1.0, 2.0, 4.0);
  const Eigen::Vector3d apart(0.0, 0.0, 4.0);
  const auto x2 = [](const Eigen::Vector3d& v, double part) {
    return Eigen::Vector3d(part * (v[1] * v[1] + v[2] * v[2]), part * (v[2] * v[2] + v[0] * v[0]),
                           part * (v[0] * v[0] + v[1] * v[1]));
  };
  static const std::vector<Known> known{
      {"sphere",
       {.radius_m = 2.0},
       4.0 / 3.0 * pi * 8.0,
       [](const auto& p) { return p.norm() < 2.0; },
       Eigen::Vector3d::Constant(4.0 / 3.0 * pi * 8.0 * 0.4 * 4.0)},
      {"capsule",
       {.kind = ShapeKind::capsule, .radius_m = 1.0, .length_m = 3.0},
       4.0 / 3.0 * pi + 3.0 * pi,
       [](const auto& p) { return (p - Eigen::Vector3d(0, 0, std::clamp(p[2], -1.5, 1.5))).norm() < 1.0; },
       Eigen::Vector3d::Zero()},
      {"ellipsoid",
       {.kind = ShapeKind::ellipsoid, .extents_m = axes},
       4.0 / 3.0 * pi * 6.0,
       [=](const auto& p) { return p.cwiseQuotient(axes).norm() < 1.0; },
       x2(axes, 4.0 / 3.0 * pi * 6.0 / 5.0)},
      {"cylinder",
       {.kind = ShapeKind::cylinder, .radius_m = 1.5, .length_m = 2.0},
       pi * 2.25 * 2.0,
       [](const auto& p) { return p.template head<2>().norm() < 1.5 && std::abs(p[2]) < 1.0; },
       pi * 4.5 * Eigen::Vector3d(2.25 / 4 + 4.0 / 12, 2.25 / 4 + 4.0 / 12, 2.25 / 2)},
      {"box", box_of(edges), 8.0, [=](const auto& p) { return in_box(p, edges); }, x2(edges, 8.0 / 12.0)},
      {"tetrahedron", tetrahedron(), 8.0 / 3.0,
       [](const auto& p) {
         return p[0] + p[1] + p[2] > -1 && -p[0] - p[1] + p[2] > -1 && -p[0] + p[1] - p[2] > -1 &&
                p[0] - p[1] - p[2] > -1;
       },
       Eigen::Vector3d::Constant(8.0 / 3.0 * 0.4)},
      {"two boxes",
       {.kind = ShapeKind::compound,
        .parts = {{.shape = box_of(edges), .position_m = -apart},
                  {.shape = box_of(edges),
                   .position_m = apart,
                   .orientation_wxyz = {std::sqrt(0.5), std::sqrt(0.5), 0, 0}}}},
       16.0,
       [=](const auto& p) {
         return in_box(p + apart, edges) || in_box(p - apart, {edges[0], edges[2], edges[1]});
       },
       Eigen::Vector3d::Zero()},
      {"crossed boxes",
       {.kind = ShapeKind::compound,
        .parts = {{.shape = box_of({2.0, 2.0, 6.0})}, {.shape = box_of({6.0, 2.0, 2.0}), .position_m = {0, 0, 0.5}}}},
       24.0 + 24.0 - 8.0,
       [](const auto& p) {
         return in_box(p, {2.0, 2.0, 6.0}) || in_box(p - Eigen::Vector3d(0, 0, 0.5), {6.0, 2.0, 2.0});
       },
       Eigen::Vector3d::Zero()},
  };
  return known;
}

class Shapes : public testing::TestWithParam<std::size_t> {
 protected:
  const Known& known = known_shapes()[GetParam()];
  std::unique_ptr<Solid> solid = make_solid(known.shape);
  std::mt19937_64 generator{7};
  std::uniform_real_distribution<double> any{-5.0, 5.0};
  Eigen::Vector3d anywhere() { return {any(generator), any(generator), any(generator)}; }
};

TEST_P(Shapes, HaveTheirVolumeAndMoments) {
  const VolumeMoments moments = solid->moments();
  const bool by_lines = std::string(known.name) == "crossed boxes";
  EXPECT_NEAR(moments.volume / known.volume, 1.0, by_lines ? 1e-3 : 1e-12);
  Shape shape = known.shape;
  if (!is_round(shape) && shape.kind != ShapeKind::cylinder)
    shape.radius_m = std::cbrt(moments.volume / (4.0 / 3.0 * std::numbers::pi));
  EXPECT_NEAR(volume_m3(shape) / moments.volume, 1.0, 1e-12);
  const Eigen::Matrix3d expected = known.inertia.asDiagonal();
  EXPECT_TRUE(known.inertia.isZero(0.0) || moments.inertia().isApprox(expected, 1e-12));
  const VolumeMoments other = moments_by_lines(*solid);
  EXPECT_NEAR(other.volume / moments.volume, 1.0, 1e-3);
  EXPECT_TRUE(other.first.isApprox(moments.first, 1e-3) || other.first.norm() < 1e-2 * moments.volume);
  EXPECT_TRUE(other.second.isApprox(moments.second, 2e-3)) << other.second << "\n" << moments.second;
}

TEST_P(Shapes, AreCrossedWhereTheyAre) {
  Intervals inside;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d origin = anywhere();
    const Eigen::Vector3d direction = anywhere();
    solid->crossings(origin, direction, inside);
    for (std::size_t j = 1; j < inside.size(); ++j) EXPECT_LT(inside[j - 1].high, inside[j].low);
    for (int k = 0; k < 20; ++k) {
      const double t = any(generator);
      const bool is_in = std::ranges::any_of(inside, [t](const auto& part) { return part.low < t && t < part.high; });
      EXPECT_EQ(is_in, known.is_inside(origin + t * direction)) << known.name << " " << origin.transpose();
    }
    EXPECT_EQ(solid->contains(origin), known.is_inside(origin));
  }
}

TEST_P(Shapes, ReachAsFarAsTheirSupport) {
  const Surface surface = solid->surface(64);
  for (int i = 0; i < 100; ++i) {
    const Eigen::Vector3d direction = anywhere();
    const double farthest = (direction.transpose() * surface.points).maxCoeff();
    const double reach = solid->support(direction).dot(direction);
    EXPECT_GE(reach, farthest - 1e-12);
    EXPECT_LE(reach, farthest + 0.01 * direction.norm() * solid->bounding_radius());
  }
  EXPECT_LE(surface.points.colwise().norm().maxCoeff(), solid->bounding_radius() + 1e-12);
  EXPECT_LE(surface.points.colwise().norm().maxCoeff(), bounding_radius_m(known.shape) + 1e-12);
  EXPECT_GE(surface.points.colwise().norm().maxCoeff(), 0.9 * bounding_radius_m(known.shape));
}

/// Every edge once in either direction, where points at the same place are one.
TEST_P(Shapes, HaveAClosedSurfaceWithItsFrontOutside) {
  if (std::string(known.name) == "crossed boxes") return;  // the parts' surfaces, one in the other
  const Surface surface = solid->surface(96);
  const auto key = [&](std::int32_t i) {
    const Eigen::Vector3i rounded = (1e6 * surface.points.col(i)).array().round().matrix().cast<int>();
    return std::array{rounded[0], rounded[1], rounded[2]};
  };
  std::map<std::pair<std::array<int, 3>, std::array<int, 3>>, int> edges;
  double volume = 0.0;
  for (std::size_t i = 0; i + 2 < surface.strip.size(); ++i) {
    const std::int32_t a = surface.strip[i + i % 2], b = surface.strip[i + 1 - i % 2], c = surface.strip[i + 2];
    if (key(a) == key(b) || key(b) == key(c) || key(c) == key(a)) continue;
    for (const auto& edge : {std::pair{key(a), key(b)}, std::pair{key(b), key(c)}, std::pair{key(c), key(a)}})
      ++edges[edge];
    volume += surface.points.col(a).dot(
                  Eigen::Vector3d(surface.points.col(b)).cross(Eigen::Vector3d(surface.points.col(c)))) /
              6.0;
    const Eigen::Vector3d outwards = Eigen::Vector3d(surface.points.col(b) - surface.points.col(a))
                                         .cross(Eigen::Vector3d(surface.points.col(c) - surface.points.col(a)));
    EXPECT_GT(outwards.dot(surface.normals.col(c)), 0.0);
  }
  for (const auto& [edge, times] : edges) {
    EXPECT_EQ(times, 1);
    EXPECT_EQ(edges.count({edge.second, edge.first}), 1U);
  }
  EXPECT_NEAR(volume / known.volume, 1.0, 0.005);
}

INSTANTIATE_TEST_SUITE_P(All, Shapes, testing::Range(std::size_t{0}, known_shapes().size()), [](const auto& info) {
  std::string name = known_shapes()[info.param].name;
  std::ranges::replace(name, ' ', '_');
  return name;
});

TEST(Surface, HasRingsWithItsAxisAlongZ) {
  const Shape sphere{.radius_m = 2.0};
  const Shape capsule{.kind = ShapeKind::capsule, .radius_m = 2.0, .length_m = 3.0};
  EXPECT_EQ(make_solid(sphere)->surface(12).points.cols(), 2 + 5 * 12) << "the equator once";
  const Surface surface = make_solid(capsule)->surface(12);
  EXPECT_EQ(surface.points.cols(), 2 + 6 * 12);
  for (Eigen::Index i = 0; i < surface.points.cols(); ++i) {
    const Eigen::Vector3d point = surface.points.col(i);
    const Eigen::Vector3d core{0, 0, std::clamp(point.z(), -1.5, 1.5)};
    EXPECT_NEAR((point - core).norm(), 2.0, 1e-12);
    EXPECT_TRUE(surface.normals.col(i).isApprox((point - core) / 2.0, 1e-12));
  }
}

TEST(Thickness, IsThatOfThePartsThatAreThin) {
  const std::map<std::string, double> expected{
      {"sphere", 4.0},    {"capsule", 2.0},      {"cylinder", 2.0}, {"box", 1.0}, {"tetrahedron", 4.0 / std::sqrt(3.0)},
      {"two boxes", 1.0}, {"crossed boxes", 2.0}};
  for (const Known& known : known_shapes()) {
    const auto found = expected.find(known.name);
    if (found == expected.end()) continue;
    EXPECT_NEAR(thickness_m(known.shape), found->second, 0.01 * found->second) << known.name;
  }
  // Normals of an ellipse whose axes are as 1 to 3 end 3√3·9/10^(3/2) = 1.48 away at least.
  const double thickness = thickness_m({.kind = ShapeKind::ellipsoid, .extents_m = {1.0, 2.0, 3.0}});
  EXPECT_GT(thickness, 1.4);
  EXPECT_LT(thickness, 2.1);
}

TEST(Solids, HaveAUnitOfLength) {
  for (const Known& known : known_shapes()) {
    const auto smaller = make_solid(known.shape, 2.0);
    EXPECT_NEAR(8.0 * smaller->moments().volume / make_solid(known.shape)->moments().volume, 1.0, 1e-12) << known.name;
  }
}

TEST(Inertia, IsThatOfTheSetupWhereItIsGiven) {
  BodySpecification body;
  body.shape = known_shapes()[4].shape;
  body.mass_kg = 3.0;
  EXPECT_NEAR(inertia_tensor_kg_m2(body)(0, 0), 3.0 / 12.0 * (4.0 + 16.0), 1e-12);
  body.inertia_kg_m2 = {1, 2, 3, 4, 5, 6};
  const Eigen::Matrix3d given{{1, 4, 5}, {4, 2, 6}, {5, 6, 3}};
  EXPECT_EQ(inertia_tensor_kg_m2(body), given);
}

}  // namespace
}  // namespace copepod
