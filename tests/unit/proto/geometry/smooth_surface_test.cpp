#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "geometry/near_surfaces.hpp"

namespace copepod {
namespace {

constexpr double far_m = 1e3;

SmoothSurface turned_ellipsoid(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& semi_axes_m, double angle) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
  return {centre_m, 0.0, R * semi_axes_m.cwiseAbs2().asDiagonal() * R.transpose()};
}

double implicit(const SmoothSurface& surface, const Eigen::Vector3d& point_m) {
  return (point_m - surface.centre_m).dot(surface.squares_m2.inverse() * (point_m - surface.centre_m));
}

TEST(SmoothSurface, OfASphereHasItsRadius) {
  const SmoothSurface sphere{{1, 2, 3}, 2.0};
  EXPECT_TRUE(sphere.support_m(Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(3, 2, 3)));
  EXPECT_TRUE(sphere.radii_m(Eigen::Vector3d::UnitX()).isApprox(Eigen::Vector3d(0, 2, 2).asDiagonal().toDenseMatrix()));
}

TEST(SmoothSurface, OfAnEllipsoidHasPointsWithTheirNormals) {
  const SmoothSurface surface = turned_ellipsoid({1, -1, 2}, {1, 2, 5}, 0.7);
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.8, 0.5).normalized();
  const Eigen::Vector3d x = surface.support_m(n);
  EXPECT_NEAR(implicit(surface, x), 1.0, 1e-12);
  EXPECT_NEAR((surface.squares_m2.inverse() * (x - surface.centre_m)).normalized().dot(n), 1.0, 1e-12);
  const Eigen::Vector3d t = n.unitOrthogonal();
  constexpr double h = 1e-5;
  const Eigen::Vector3d slope =
      (surface.support_m((n + h * t).normalized()) - surface.support_m((n - h * t).normalized())) / (2.0 * h);
  EXPECT_LT((slope - surface.radii_m(n) * t).norm(), 1e-8);
}

TEST(Separation, IsNotImprovedBeyondWhatIsFar) {
  const SmoothSurface first = turned_ellipsoid({6, 1, 0}, {1, 2, 3}, 0.7), second{{0, 0, 0}, 1.0};
  const double exact_m = separation(first, second, far_m).gap_m;
  const double bound_m = separation(first, second, 1.0).gap_m;
  EXPECT_GT(bound_m, 1.0);
  EXPECT_LT(bound_m, exact_m - 0.01);
}

/// Whether it is less than a reach is the same as by the gap itself.
TEST(Separation, IsNotImprovedBeyondWhatIsCertainlyNear) {
  int changed = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const SmoothSurface first = turned_ellipsoid({2.0 + 0.01 * trial, 1.0, 0.2}, {1, 2, 0.4}, 0.1 * trial);
    const SmoothSurface second = turned_ellipsoid({0, 0, 0}, {0.5, 1, 3}, 0.03 * trial);
    const double exact_m = separation(first, second, far_m).gap_m;
    for (const double reach_m : {0.25, 1.0}) {
      const double gap_m = separation(first, second, reach_m, reach_m).gap_m;
      EXPECT_EQ(gap_m < reach_m, exact_m < reach_m) << trial;
      EXPECT_LE(gap_m, exact_m + 1e-12) << trial;
      changed += gap_m < exact_m - 1e-6 && exact_m < reach_m ? 1 : 0;
    }
  }
  EXPECT_GT(changed, 50);
}

/// No other pair of points on the two surfaces is closer.
TEST(Separation, IsTheLeastDistanceOfEllipsoidsApart) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int trial = 0; trial < 300; ++trial) {
    const auto semi_axes = [&] { return Eigen::Vector3d(5.0 + 4.5 * any(generator), 0.2, 5.0 + 4.0 * any(generator)); };
    const Eigen::Vector3d way = Eigen::Vector3d(any(generator), any(generator), any(generator)).normalized();
    const SmoothSurface first = turned_ellipsoid(19.0 * way, semi_axes(), 3.0 * any(generator));
    SmoothSurface second = turned_ellipsoid({0, 0, 0}, semi_axes(), 3.0 * any(generator));
    if (trial % 3 == 0) second = {{0, 0, 0}, 1.5};
    if (trial % 3 == 1) second = {};  // a point
    const auto [n, gap_m] = separation(first, second, far_m);
    ASSERT_GT(gap_m, 0.0);
    const Eigen::Vector3d x = first.support_m(-n), y = second.support_m(n);
    EXPECT_LT((x - y - gap_m * n).norm(), 1e-9) << trial;
  }
}

TEST(Separation, ConvergesForTouchingAndOverlappingSurfaces) {
  const Eigen::Vector3d a(1, 1, 4);
  for (const double gap : {1e-9, 0.0, -0.02}) {
    const auto found =
        separation(turned_ellipsoid({2.0 + gap, 0.3, 0.0}, a, 0.0), turned_ellipsoid({0, 0, 0}, a, 0.0), far_m);
    const double exact = found.gap_m;
    for (int i = 0; i < 200; ++i) {  // no direction has a larger gap
      const Eigen::Vector3d n =
          (found.normal + 0.01 * Eigen::Vector3d(std::sin(i), std::cos(2 * i), std::sin(3 * i))).normalized();
      const Eigen::Vector3d apart_m = turned_ellipsoid({2.0 + gap, 0.3, 0.0}, a, 0.0).support_m(-n) -
                                      turned_ellipsoid({0, 0, 0}, a, 0.0).support_m(n);
      EXPECT_LE(n.dot(apart_m), exact + 1e-12);
    }
  }
}

}  // namespace
}  // namespace copepod
