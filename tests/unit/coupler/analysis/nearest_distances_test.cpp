#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "analysis/swimmer_figures.hpp"

namespace copepod::coupler {
namespace {

/// Every point against every other one.
Eigen::VectorXd searched_m(const Eigen::Matrix3Xd& points_m, const std::array<double, 3>& periodic_length_m) {
  Eigen::VectorXd nearest_m = Eigen::VectorXd::Constant(points_m.cols(), std::numeric_limits<double>::infinity());
  for (Eigen::Index a = 0; a < points_m.cols(); ++a) {
    for (Eigen::Index b = 0; b < points_m.cols(); ++b) {
      Eigen::Vector3d way_m = points_m.col(b) - points_m.col(a);
      for (Eigen::Index axis = 0; axis < 3; ++axis) {
        const double length_m = periodic_length_m[static_cast<std::size_t>(axis)];
        if (length_m > 0.0) way_m[axis] -= length_m * std::round(way_m[axis] / length_m);
      }
      if (a != b) nearest_m[a] = std::min(nearest_m[a], way_m.norm());
    }
  }
  return nearest_m;
}

constexpr std::array<double, 3> open{0.0, 0.0, 0.0};

TEST(NearestDistances, AreThoseOfASearchThroughAllPairs) {
  std::srand(3);
  const Eigen::Matrix3Xd spread_m = 1e-4 * Eigen::Matrix3Xd::Random(3, 500);
  Eigen::Matrix3Xd with_outlier_m = spread_m;
  with_outlier_m.col(7) << 0.1, -0.2, 0.3;
  Eigen::Matrix3Xd in_a_row_m = spread_m;
  in_a_row_m.topRows(2).setZero();
  for (const Eigen::Matrix3Xd& points_m : {spread_m, with_outlier_m, in_a_row_m}) {
    EXPECT_EQ(nearest_distances_m(points_m, open), searched_m(points_m, open));
    for (const std::array<double, 3>& period_m : {std::array{2e-4, 2e-4, 2e-4}, std::array{0.0, 1.5e-4, 0.0}})
      EXPECT_EQ(nearest_distances_m(points_m, period_m), searched_m(points_m, period_m));
  }
}

TEST(NearestDistances, OfTwoAndOfCoincidingPoints) {
  Eigen::Matrix3Xd two_m(3, 2);
  two_m << 0, 3, 0, 0, 0, 4;
  EXPECT_EQ(nearest_distances_m(two_m, open), Eigen::Vector2d(5, 5));
  EXPECT_EQ(nearest_distances_m(two_m, {0, 0, 4}), Eigen::Vector2d(3, 3));
  EXPECT_EQ(nearest_distances_m(Eigen::Matrix3Xd::Ones(3, 3), open), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace copepod::coupler
