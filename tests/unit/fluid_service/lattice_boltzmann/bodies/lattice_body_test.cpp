#include "lattice_boltzmann/bodies/lattice_body.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

LatticeBody body_of(ShapeKind kind, double radius, double half_length, const Eigen::Vector3d& axis) {
  LatticeBody body;
  body.kind = kind;
  body.radius = radius;
  body.half_length = half_length;
  body.position = {14.83, 15.21, 15.07};
  body.axis = axis.normalized();
  return body;
}

std::vector<LatticeBody> bodies() {
  std::vector<LatticeBody> all = {body_of(ShapeKind::sphere, 4.3, 0.0, {0, 0, 1})};
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 1), Eigen::Vector3d(3, -2, 1),
        Eigen::Vector3d(1, 2, -0.01), Eigen::Vector3d(0.1, -0.2, 1)})
    all.push_back(body_of(ShapeKind::capsule, 3.3, 4.55, axis));
  return all;
}

/// Signed distance to the surface, by definition: the distance to the capsule's axis, less the radius.
double distance(const LatticeBody& body, const Eigen::Vector3d& r) {
  const double along = std::clamp(r.dot(body.axis), -body.half_length, body.half_length);
  return (r - along * body.axis).norm() - body.radius;
}

Eigen::Vector3d centre_of(std::int64_t x, std::int64_t y, std::int64_t z) {
  return Eigen::Vector3d(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)).array() + 0.5;
}

/// In every row of a box of `size` cells in each direction.
void expect_cells_whose_centres_lie_inside(const LatticeBody& body, std::int64_t size) {
  for (std::int64_t x = 0; x < size; ++x)
    for (std::int64_t y = 0; y < size; ++y) {
      const RowInterval row = covered_cells(body, x, y);
      for (std::int64_t z = 0; z < size; ++z)
        ASSERT_EQ(z >= row.low && z < row.high, distance(body, centre_of(x, y, z) - body.position) < 0.0)
            << x << " " << y << " " << z << ", axis " << body.axis.transpose();
    }
}

TEST(RowInterval, HoldsTheCellsWhoseCentresLieInside) {
  for (const LatticeBody& body : bodies()) expect_cells_whose_centres_lie_inside(body, 30);
}

TEST(RowInterval, HoldsTheCellsOfARowThatTheBodyBarelyCuts) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(3.0, 4.0);
  for (int i = 0; i < 200; ++i) {
    LatticeBody body = body_of(ShapeKind::sphere, 1.7, 0.0, {0, 0, 1});
    body.position = {place(random), place(random), place(random)};
    expect_cells_whose_centres_lie_inside(body, 7);
  }
}

TEST(RowInterval, LeavesOutACentreOnTheSurface) {
  LatticeBody body = body_of(ShapeKind::sphere, 2.0, 0.0, {0, 0, 1});
  body.position = {4.5, 4.5, 4.5};
  EXPECT_EQ(covered_cells(body, 4, 4), (RowInterval{3, 6}));
  EXPECT_TRUE(covered_cells(body, 6, 4).empty());
}

/// visit(r, α) for every link of the body.
template <class Visit>
void for_each_link(const LatticeBody& body, const Visit& visit) {
  for (int x = 0; x < 30; ++x)
    for (int y = 0; y < 30; ++y)
      for (int z = 0; z < 30; ++z) {
        const Eigen::Vector3d r = centre_of(x, y, z) - body.position;
        if (distance(body, r) < 0.0) continue;
        for (const d3q19::Direction& e : d3q19::e)
          if (distance(body, r + Eigen::Vector3d(e[0], e[1], e[2])) < 0.0) visit(r, e);
      }
}

TEST(WallDistance, EndsOnTheSurfaceWhereTheLinkFirstMeetsIt) {
  for (const LatticeBody& body : bodies()) {
    int links = 0;
    for_each_link(body, [&](const Eigen::Vector3d& r, const d3q19::Direction& e) {
      const Eigen::Vector3d link(e[0], e[1], e[2]);
      const double q = wall_distance(body, r, d3q19::index_of(e));
      ASSERT_GE(q, 0.0);
      ASSERT_LE(q, 1.0);
      ASSERT_NEAR(distance(body, r + q * link), 0.0, 1e-13);
      for (int i = 1; i < 20; ++i) ASSERT_GT(distance(body, r + q * (i / 20.0) * link), -1e-13);
      ++links;
    });
    EXPECT_GT(links, 1000);
  }
}

TEST(WallDistance, OfKnownLinks) {
  const LatticeBody sphere = body_of(ShapeKind::sphere, 2.0, 0.0, {0, 0, 1});
  EXPECT_NEAR(wall_distance(sphere, {2.25, 0.0, 0.0}, d3q19::index_of({-1, 0, 0})), 0.25, 1e-15);
  EXPECT_NEAR(wall_distance(sphere, {1.75, 1.75, 0.0}, d3q19::index_of({-1, -1, 0})), 1.75 - std::sqrt(2.0), 1e-15);
  const LatticeBody capsule = body_of(ShapeKind::capsule, 2.0, 3.0, {1, 0, 0});
  EXPECT_NEAR(wall_distance(capsule, {5.75, 0.0, 0.0}, d3q19::index_of({-1, 0, 0})), 0.75, 1e-15);  // end sphere
  EXPECT_NEAR(wall_distance(capsule, {1.0, 2.5, 0.0}, d3q19::index_of({0, -1, 0})), 0.5, 1e-15);    // cylinder
  EXPECT_NEAR(wall_distance(capsule, {1.0, 2.5, 0.0}, d3q19::index_of({1, -1, 0})), 0.5, 1e-15);
}

TEST(WallDistance, KeepsItsDigitsWhereTheCellTouchesTheSurface) {
  const LatticeBody sphere = body_of(ShapeKind::sphere, 2.0, 0.0, {0, 0, 1});
  EXPECT_NEAR(wall_distance(sphere, {2.0 + 1e-9, 0.0, 0.0}, d3q19::index_of({-1, 0, 0})) / 1e-9, 1.0, 1e-6);
}

}  // namespace
}  // namespace copepod::fluid
