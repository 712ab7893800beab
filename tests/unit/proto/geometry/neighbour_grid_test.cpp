#include "geometry/neighbour_grid.hpp"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace copepod {
namespace {

struct Cloud {
  std::vector<double> radius;
  Eigen::Matrix3Xd centre;
};

Cloud random_cloud(int balls, double box, double smallest, double largest, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-box, 2.0 * box);  // outside a periodic box, too
  std::uniform_real_distribution<double> size(std::log(smallest), std::log(largest));
  Cloud cloud;
  cloud.centre.resize(3, balls);
  for (int i = 0; i < balls; ++i) {
    cloud.radius.push_back(std::exp(size(random)));
    cloud.centre.col(i) << place(random), place(random), place(random);
  }
  return cloud;
}

std::vector<BodyPair> all_pairs(const Cloud& cloud, const NeighbourGrid& grid) {
  std::vector<BodyPair> pairs;
  const int balls = static_cast<int>(cloud.radius.size());
  for (int i = 0; i < balls; ++i) {
    for (int j = i + 1; j < balls; ++j) {
      const double distance = grid.images().nearest_m(cloud.centre.col(j) - cloud.centre.col(i)).norm();
      if (distance < cloud.radius[i] + cloud.radius[j]) pairs.emplace_back(i, j);
    }
  }
  return pairs;
}

void expect_all_pairs_found(const Cloud& cloud, const std::array<double, 3>& periodic_length) {
  NeighbourGrid grid(cloud.radius, periodic_length);
  std::vector<BodyPair> found{{7, 7}};
  grid.find_pairs(cloud.centre, found);
  std::sort(found.begin(), found.end());
  const auto expected = all_pairs(cloud, grid);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(found, expected);
}

TEST(NeighbourGrid, FindsEveryPairOnceInOpenSpace) {
  expect_all_pairs_found(random_cloud(400, 10.0, 0.9, 1.1, 1), {0, 0, 0});
}

TEST(NeighbourGrid, FindsEveryPairOfBallsOfVeryDifferentSize) {
  expect_all_pairs_found(random_cloud(400, 10.0, 0.05, 5.0, 2), {0, 0, 0});
}

TEST(NeighbourGrid, FindsPairsAcrossPeriodicFaces) {
  expect_all_pairs_found(random_cloud(300, 10.0, 0.3, 1.5, 3), {10.0, 0, 10.0});
}

TEST(NeighbourGrid, FindsPairsInPeriodicBoxesOfOneTwoAndThreeCells) {
  for (const double length : {1.5, 2.5, 4.9, 6.1, 7.0}) {
    expect_all_pairs_found(random_cloud(60, 7.0, 0.6, 1.0, 4), {length, 7.0, length});
  }
}

TEST(NeighbourGrid, CopesWithBallsFarOutside) {
  Cloud cloud = random_cloud(200, 5.0, 0.9, 1.1, 5);
  cloud.centre.col(0).setConstant(1e200);
  cloud.centre.col(1).setConstant(-1e200);
  expect_all_pairs_found(cloud, {0, 0, 0});
}

TEST(NeighbourGrid, ListsPairsInTheSameOrderEveryTime) {
  const Cloud cloud = random_cloud(300, 5.0, 0.2, 2.0, 6);
  NeighbourGrid grid(cloud.radius, {0, 0, 0});
  std::vector<BodyPair> first;
  std::vector<BodyPair> second;
  grid.find_pairs(cloud.centre, first);
  grid.find_pairs(cloud.centre, second);
  EXPECT_EQ(first, second);
}

}  // namespace
}  // namespace copepod
