#include "geometry/near_surfaces.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace copepod {
namespace {

/// A box of 20 cells of 1 m with spheres of radius 2 m.
FluidSetup box(std::size_t spheres, BoundaryKind boundary) {
  FluidSetup setup;
  setup.cell_size_m = 1.0;
  setup.domain_cells = {20, 20, 20};
  for (Boundary& face : setup.boundaries) face.kind = boundary;
  setup.bodies.assign(spheres, {ShapeKind::sphere, 2.0, 0.0});
  return setup;
}

Kinematics at(const std::vector<Eigen::Vector3d>& places) {
  Kinematics kinematics;
  kinematics.resize(static_cast<Eigen::Index>(places.size()));
  kinematics.velocity_m_per_s.setZero();
  kinematics.angular_velocity_rad_per_s.setZero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    kinematics.position_m.col(static_cast<Eigen::Index>(i)) = places[i];
    kinematics.orientation_wxyz.col(static_cast<Eigen::Index>(i)) = Eigen::Vector4d(1, 0, 0, 0);
  }
  return kinematics;
}

TEST(FilmRange, IsResolvedFromHalfACellAboveTheFilmThicknessOn) {
  FluidSetup setup = box(0, BoundaryKind::no_slip);
  setup.film_thickness_m = 1.5;
  const FilmRange range(setup);
  EXPECT_DOUBLE_EQ(range.resolved_share(0.3), 0.0);
  EXPECT_DOUBLE_EQ(range.resolved_share(1.25), 0.25);
  EXPECT_DOUBLE_EQ(range.resolved_share(2.5), 1.0);
}

TEST(NearSurfaces, AreThoseOfBodiesAndWallsWithinReach) {
  NearSurfaces surfaces(box(3, BoundaryKind::no_slip), 1.0);
  surfaces.find(at({{10, 10, 2.5}, {14.5, 10, 3.5}, {10, 16, 10}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 2U);
  const NearSurface& sphere = surfaces.of_body(0)[0];
  EXPECT_EQ(sphere.other, 1);
  EXPECT_DOUBLE_EQ(sphere.from({2, 0, 0}).m, std::hypot(2.5, 1.0) - 2.0);
  const NearSurface& wall = surfaces.of_body(0)[1];
  EXPECT_EQ(wall.face, 4);
  EXPECT_DOUBLE_EQ(wall.from({0, 0, -2}).m, 0.5);
  ASSERT_EQ(surfaces.of_body(1).size(), 1U);
  EXPECT_EQ(surfaces.of_body(1)[0].other, 0);
  EXPECT_TRUE(surfaces.of_body(2).empty());
}

TEST(NearSurfaces, AreThoseBetweenWhichFilmsAreKnown) {
  FluidSetup setup = box(3, BoundaryKind::no_slip);
  setup.bodies[1] = {.kind = ShapeKind::ellipsoid, .radius_m = 2.0, .extents_m = {2, 1, 4}};
  const Kinematics kinematics = at({{10, 10, 2.5}, {14.5, 10, 4.5}, {10, 14.5, 4.0}});
  using Others = std::vector<std::pair<int, int>>;  // body, face
  const auto others = [&](std::size_t body, const Shape& first) {
    setup.bodies[0] = first;
    NearSurfaces surfaces(setup, 1.0);
    surfaces.find(kinematics);
    Others found;
    for (const NearSurface& surface : surfaces.of_body(body)) found.emplace_back(surface.other, surface.face);
    return found;
  };
  const Shape sphere{ShapeKind::sphere, 2.0, 0.0}, capsule{ShapeKind::capsule, 2.0, 1e-6};
  EXPECT_EQ(others(0, sphere), (Others{{1, -1}, {2, -1}, {-1, 4}}));
  EXPECT_EQ(others(1, sphere), (Others{{0, -1}, {-1, 4}}));
  EXPECT_EQ(others(0, capsule), (Others{{2, -1}, {-1, 4}}));
  EXPECT_EQ(others(1, capsule), (Others{{-1, 4}}));
  EXPECT_EQ(others(0, {ShapeKind::box, 2.0, 0.0, {4, 4, 4}}), Others{});
}

TEST(NearSurfaces, OfAnEllipsoidInAMirrorIsItsImage) {
  FluidSetup setup = box(1, BoundaryKind::free_slip);
  setup.bodies[0] = {.kind = ShapeKind::ellipsoid, .radius_m = 2.0, .extents_m = {3, 2, 4}};
  Kinematics kinematics = at({{10, 10, 3.96}});
  kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(std::cos(0.3), 0, std::sin(0.3), 0);
  NearSurfaces surfaces(setup, 1.0);
  surfaces.find(kinematics);
  ASSERT_EQ(surfaces.of_body(0).size(), 1U);
  const Eigen::Vector3d n(0.0, 0.0, 1.0);
  const Eigen::Vector3d nearest = surfaces.surface_of(0).smooth().support_m(-n) - Eigen::Vector3d(10, 10, 3.96);
  EXPECT_NEAR(surfaces.of_body(0)[0].from(nearest).m, 2.0 * (3.96 + nearest.z()), 0.01);
  EXPECT_GT(std::abs(nearest.x()), 0.5);
}

/// Two bodies of a shape, one of which is turned.
NearSurface turned(const Shape& shape) {
  FluidSetup setup = box(2, BoundaryKind::no_slip);
  setup.domain_cells = {60, 60, 60};
  setup.bodies.assign(2, shape);
  Kinematics kinematics = at({{30, 30, 30}, {33, 31, 29}});
  kinematics.orientation_wxyz.col(1) = Eigen::Vector4d(0.5, 0.1, -0.7, 0.5).normalized();
  NearSurfaces surfaces(setup, 20.0);
  surfaces.find(kinematics);
  EXPECT_EQ(surfaces.of_body(0).size(), 1U);
  return surfaces.of_body(0)[0];
}

/// Points away from a surface, with how far they are.
void for_each_point(const NearSurface& surface, const auto& check) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Vector3d n = Eigen::Vector3d(any(generator), any(generator), any(generator)).normalized();
    const double side = surface.core.half_W_m.dot(n) > 0.0 ? 1.0 : -1.0;
    const Eigen::Vector3d nearest_m = surface.smooth().support_m(n) + side * surface.core.half_W_m;
    for (const double distance_m : {0.1, 0.5, 1.0, 3.0}) check(nearest_m + distance_m * n, n, distance_m);
  }
}

TEST(NearSurface, IsAsFarFromAPointAsItsNearestPoint) {
  for (const NearSurface& surface : {turned({ShapeKind::sphere, 2.0, 0.0}), turned({ShapeKind::capsule, 1.0, 4.0}),
                                     turned({.kind = ShapeKind::ellipsoid, .radius_m = 2.0, .extents_m = {2, 2, 2}})})
    for_each_point(surface, [&](const Eigen::Vector3d& point_m, const Eigen::Vector3d& n, double distance_m) {
      EXPECT_NEAR(surface.from(point_m).m, distance_m, 1e-12);
      EXPECT_LT((surface.from(point_m).normal - n).norm(), 1e-12);
    });
  const NearSurface ellipsoid = turned({.kind = ShapeKind::ellipsoid, .radius_m = 4.0, .extents_m = {2, 3, 4}});
  for_each_point(ellipsoid, [&](const Eigen::Vector3d& point_m, const Eigen::Vector3d&, double distance_m) {
    if (distance_m > 1.0) return;
    EXPECT_NEAR(ellipsoid.from(point_m).m, distance_m, 0.1 * distance_m * distance_m);
  });
}

TEST(NearSurface, IsNotNearerThanItsPlanesNorFurtherThanItsStretchAllows) {
  for (const Shape& shape : {Shape{ShapeKind::sphere, 2.0, 0.0}, Shape{ShapeKind::capsule, 1.0, 4.0},
                             Shape{.kind = ShapeKind::ellipsoid, .radius_m = 2.5, .extents_m = {0.5, 1.0, 2.5}}}) {
    const NearSurface surface = turned(shape);
    const double ratio = 2.5 / 0.5;
    EXPECT_DOUBLE_EQ(surface.stretch, surface.is_ellipsoid() ? 0.5 * (ratio + 1.0 / ratio) : 1.0);
    for_each_point(surface, [&](const Eigen::Vector3d& point_m, const Eigen::Vector3d&, double distance_m) {
      const auto [m, normal] = surface.from(point_m);
      EXPECT_LE(surface.beyond_plane_m(point_m), distance_m + 1e-12);
      EXPECT_LE(m, distance_m + 1e-12);
      EXPECT_GE(surface.stretch * m, distance_m - 1e-12);
      const Eigen::Vector3d touched_m = surface.smooth().support_m(normal) +
                                        (surface.core.half_W_m.dot(normal) > 0.0 ? 1.0 : -1.0) * surface.core.half_W_m;
      EXPECT_NEAR(normal.dot(point_m - touched_m), m, 1e-9);
    });
    const Eigen::Vector3d end_m =
        surface.smooth().support_m(surface.normal) +
        (surface.core.half_W_m.dot(surface.normal) > 0.0 ? 1.0 : -1.0) * surface.core.half_W_m;
    EXPECT_NEAR(surface.beyond_plane_m(end_m), 0.0, 1e-12);
    EXPECT_LT((surface.normal + surface.core.centre_W_m.normalized()).norm(), 1e-12);
  }
}

TEST(NearSurfaces, AreThoseOfPeriodicImages) {
  NearSurfaces surfaces(box(2, BoundaryKind::periodic), 1.0);
  surfaces.find(at({{10, 10, 1.5}, {10, 10, 17.0}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 1U);
  EXPECT_DOUBLE_EQ(surfaces.of_body(0)[0].core.centre_W_m.z(), -4.5);
  ASSERT_EQ(surfaces.of_body(1).size(), 1U);
  EXPECT_DOUBLE_EQ(surfaces.of_body(1)[0].core.centre_W_m.z(), 4.5);
}

TEST(NearSurfaces, AreThoseOnBothSidesInAPeriodicRow) {
  FluidSetup setup = box(2, BoundaryKind::no_slip);
  setup.boundaries[4].kind = setup.boundaries[5].kind = BoundaryKind::periodic;
  for (Shape& sphere : setup.bodies) sphere.radius_m = 4.75;
  NearSurfaces surfaces(setup, 1.0);
  surfaces.find(at({{10, 10, 5.03}, {10, 10, 15.01 + 20}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 2U);
  EXPECT_NEAR(surfaces.of_body(0)[0].core.centre_W_m.z(), 9.98 - 20, 1e-12);
  EXPECT_NEAR(surfaces.of_body(0)[1].core.centre_W_m.z(), 9.98, 1e-12);
  EXPECT_EQ(surfaces.of_body(1).size(), 2U);
}

TEST(NearSurfaces, AreThoseOfABodysOwnImages) {
  FluidSetup setup = box(1, BoundaryKind::periodic);
  setup.bodies[0].radius_m = 9.75;
  NearSurfaces surfaces(setup, 1.0);
  surfaces.find(at({{3, 4, 5}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 6U);
  for (const NearSurface& image : surfaces.of_body(0)) {
    EXPECT_EQ(image.other, 0);
    EXPECT_FALSE(image.is_mirrored());
    EXPECT_DOUBLE_EQ(image.core.centre_W_m.norm(), 20.0);
  }
}

TEST(NearSurfaces, AreThoseOfImagesInMirrors) {
  NearSurfaces surfaces(box(2, BoundaryKind::free_slip), 1.0);
  surfaces.find(at({{10, 10, 2.25}, {14.25, 10, 2.25}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 2U);
  EXPECT_EQ(surfaces.of_body(0)[0].other, 0);  // its own image
  EXPECT_DOUBLE_EQ(surfaces.of_body(0)[0].core.centre_W_m.z(), -4.5);
  EXPECT_TRUE(surfaces.of_body(0)[0].mirrored[2]);
  EXPECT_EQ(surfaces.of_body(0)[1].other, 1);
  EXPECT_FALSE(surfaces.of_body(0)[1].mirrored[2]);
}

TEST(NearSurfaces, OfBodiesThatOverlapAtAJointAreTheirImagesInMirrorsOnly) {
  FluidSetup setup = box(3, BoundaryKind::free_slip);
  setup.jointed = {{1, 2}, {0, 1}};  // in any order
  NearSurfaces surfaces(setup, 1.0);
  surfaces.find(at({{6.5, 10, 10}, {10, 10, 10}, {10, 14 - 1e-12, 10}}));
  for (std::size_t body = 0; body < 3; ++body) EXPECT_TRUE(surfaces.of_body(body).empty()) << body;
  surfaces.find(at({{6, 10, 2}, {8, 10, 2}, {10, 10, 10}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 2U);
  EXPECT_TRUE(surfaces.of_body(0)[0].mirrored[2]);
  EXPECT_EQ(surfaces.of_body(0)[1].other, 1);
  EXPECT_TRUE(surfaces.of_body(0)[1].mirrored[2]);
  surfaces.find(at({{5.5, 10, 10}, {10, 10, 10}, {10, 15, 10}}));
  ASSERT_EQ(surfaces.of_body(0).size(), 1U) << "they are apart";
  EXPECT_EQ(surfaces.of_body(0)[0].other, 1);
}

TEST(NearSurfaces, OfACapsuleBesideAMirrorTurnWithTheImage) {
  FluidSetup setup = box(1, BoundaryKind::free_slip);
  setup.bodies[0] = {ShapeKind::capsule, 1.0, 4.0};
  NearSurfaces surfaces(setup, 1.0);
  Kinematics kinematics = at({{10, 10, 2.5}});
  kinematics.orientation_wxyz.col(0) = Eigen::Vector4d(std::cos(0.5), std::sin(0.5), 0, 0);  // about x
  surfaces.find(kinematics);
  ASSERT_EQ(surfaces.of_body(0).size(), 1U);
  EXPECT_NEAR(surfaces.of_body(0)[0].core.half_W_m.y(), -2.0 * std::sin(1.0), 1e-12);
  EXPECT_NEAR(surfaces.of_body(0)[0].core.half_W_m.z(), -2.0 * std::cos(1.0), 1e-12);
}

TEST(NearSurfaces, OfABodyOnASymmetryPlaneAreNotItsOwn) {
  FluidSetup setup = box(2, BoundaryKind::no_slip);
  setup.symmetry_planes[2] = true;
  NearSurfaces surfaces(setup, 1.0);
  surfaces.find(at({{10, 10, 10}, {5, 10, 7.75}}));
  EXPECT_TRUE(surfaces.of_body(0).empty());
  ASSERT_EQ(surfaces.of_body(1).size(), 1U);
  EXPECT_DOUBLE_EQ(surfaces.of_body(1)[0].core.centre_W_m.z(), 4.5);
}

}  // namespace
}  // namespace copepod
