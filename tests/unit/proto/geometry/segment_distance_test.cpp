#include "geometry/segment_distance.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace copepod {
namespace {

/// Smallest distance over a lattice of points on both segments, refined around the best one.
double by_search(const CoreSegment& first, const CoreSegment& second) {
  constexpr int places = 20;
  double s_middle = 0.0;
  double t_middle = 0.0;
  double width = 1.0;
  double smallest = 1e300;
  for (int refinement = 0; refinement < 14; ++refinement) {
    double s_best = s_middle;
    double t_best = t_middle;
    for (int i = -places; i <= places; ++i) {
      for (int j = -places; j <= places; ++j) {
        const double s = std::clamp(s_middle + width * i / places, -1.0, 1.0);
        const double t = std::clamp(t_middle + width * j / places, -1.0, 1.0);
        const double distance =
            (second.centre_W_m + t * second.half_W_m - first.centre_W_m - s * first.half_W_m).norm();
        if (distance < smallest) {
          smallest = distance;
          s_best = s;
          t_best = t;
        }
      }
    }
    s_middle = s_best;
    t_middle = t_best;
    width *= 0.3;
  }
  return smallest;
}

TEST(SegmentDistance, AgreesWithASearchForRandomSegments) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  const auto vector = [&] { return Eigen::Vector3d(number(random), number(random), number(random)); };
  for (int i = 0; i < 300; ++i) {
    const CoreSegment first{vector(), vector()};
    const CoreSegment second{vector(), i % 5 == 0 ? Eigen::Vector3d::Zero() : vector()};
    EXPECT_NEAR(segment_distance_m(first, second), by_search(first, second), 1e-5) << "pair " << i;
    EXPECT_NEAR(segment_distance_m(first, second), segment_distance_m(second, first), 1e-14);
  }
}

TEST(SegmentDistance, OfTwoPointsIsTheirDistance) {
  EXPECT_DOUBLE_EQ(segment_distance_m({{0, 0, 0}, {0, 0, 0}}, {{1, 2, 2}, {0, 0, 0}}), 3.0);
}

TEST(SegmentDistance, OfParallelSegmentsSideBySideIsTheGapBetweenTheLines) {
  EXPECT_DOUBLE_EQ(segment_distance_m({{0, 0, 0}, {0, 0, 1}}, {{3, 0, 1.5}, {0, 0, 1}}), 3.0);
}

TEST(SegmentDistance, OfCollinearSegmentsIsTheGapBetweenTheirEnds) {
  EXPECT_DOUBLE_EQ(segment_distance_m({{0, 0, 0}, {0, 0, 1}}, {{0, 0, 5}, {0, 0, 1.5}}), 2.5);
}

TEST(SegmentDistance, OfCrossingSegmentsIsZero) {
  EXPECT_NEAR(segment_distance_m({{0, 0, 0}, {1, 1, 0}}, {{0, 0, 0}, {1, -1, 0}}), 0.0, 1e-15);
}

TEST(SegmentDistance, OfNearlyParallelSegmentsIsFoundWhereTheyCross) {
  // They pass each other at a distance of 0.1, far from both middles, whatever the angle between them.
  for (const double angle : {0.3, 0.05, 1e-2, 1e-3, 1e-5, 1e-7, 1e-9}) {
    const Eigen::Vector3d half(std::cos(angle), std::sin(angle), 0.0);
    const CoreSegment first{{0, 0, 0}, {1, 0, 0}};
    const CoreSegment second{Eigen::Vector3d(0.8, 0, 0.1) - 0.8 * half, half};
    EXPECT_NEAR(segment_distance_m(first, second), 0.1, 1e-12) << "angle " << angle;
    EXPECT_NEAR(segment_distance_m(second, first), 0.1, 1e-12) << "angle " << angle;
  }
}

TEST(SegmentDistance, BetweenAnEndAndTheMiddleOfTheOther) {
  EXPECT_DOUBLE_EQ(segment_distance_m({{0, 0, 3}, {0, 0, 1}}, {{0, 0, 0}, {5, 0, 0}}), 2.0);
}

}  // namespace
}  // namespace copepod
