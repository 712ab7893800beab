#include "geometry/periodic_images.hpp"

#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace copepod {
namespace {

TEST(PeriodicImages, AreAllThatAreNearerThanTheReach) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-30.0, 30.0);
  std::uniform_real_distribution<double> half(-6.0, 6.0);
  const PeriodicImages images{{10.0, 0.0, 7.0}};
  const auto point = [&](auto& of) { return Eigen::Vector3d(of(random), of(random), of(random)); };
  int several = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const CoreSegment first{point(place), point(half)};
    const CoreSegment second{Eigen::Vector3d(point(place)[0], first.centre_W_m[1] + half(random), point(place)[2]),
                             point(half)};
    const double reach = 14.0;
    const Eigen::Vector3d apart = second.centre_W_m - first.centre_W_m;
    double smallest = std::numeric_limits<double>::infinity();
    int expected = 0;
    for (int x = -12; x <= 12; ++x) {
      for (int z = -16; z <= 16; ++z) {
        const Eigen::Vector3d at = apart + Eigen::Vector3d(10.0 * x, 0.0, 7.0 * z);
        if (at.norm() >= reach) continue;
        ++expected;
        smallest =
            std::min(smallest, segment_distance_m({Eigen::Vector3d::Zero(), first.half_W_m}, {at, second.half_W_m}));
      }
    }
    int found = 0;
    images.for_each(apart, reach, [&](const Eigen::Vector3d& at, const Eigen::Vector3d& number) {
      ++found;
      EXPECT_LT((at - apart - Eigen::Vector3d(10.0 * number[0], 0.0, 7.0 * number[2])).norm(), 1e-12);
    });
    EXPECT_EQ(found, expected);
    EXPECT_EQ(images.smallest_distance_m(first, second, reach), smallest);
    several += expected > 1 ? 1 : 0;
  }
  EXPECT_GT(several, 100);
}

TEST(PeriodicImages, OfABodyDoNotIncludeTheBodyItself) {
  const CoreSegment rod{Eigen::Vector3d(1, 2, 3), Eigen::Vector3d(0, 0, 2)};
  EXPECT_DOUBLE_EQ((PeriodicImages{{0.0, 0.0, 9.0}}.smallest_distance_m(rod, rod, 9.5, true)), 5.0);
  EXPECT_EQ((PeriodicImages{}.smallest_distance_m(rod, rod, 9.5, true)), std::numeric_limits<double>::infinity());
}

TEST(PeriodicImages, AreNoneOfAPointOutOfAllProportion) {
  PeriodicImages{{1e-6, 1e-6, 1e-6}}.for_each({1e100, 0, 0}, 1e100, [](const auto&, const auto&) { FAIL(); });
}

}  // namespace
}  // namespace copepod
