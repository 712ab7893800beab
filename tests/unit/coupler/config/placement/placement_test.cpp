#include "config/placement/placement.hpp"

#include <limits>
#include <set>

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

constexpr double box_m = 40.0;

/// Two balls of radius 1 that are 4 apart.
std::vector<BodySpecification> dumb_bell() {
  std::vector<BodySpecification> bodies(2);
  for (const std::size_t end : {0U, 1U}) {
    bodies[end].shape.radius_m = 1.0;
    bodies[end].position_m = Eigen::Vector3d(0, 0, end == 0 ? -2.0 : 2.0);
  }
  return bodies;
}

/// A box with walls along x and y, periodic along z.
Room channel_room(double gap_m) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  Room room;
  room.least_m = Eigen::Vector3d(0, 0, -infinity);
  room.most_m = Eigen::Vector3d(box_m, box_m, infinity);
  room.periodic_length_m = {0, 0, box_m};
  room.gap_m = gap_m;
  return room;
}

std::function<Place()> drawing_places(RandomNumbers& random) {
  return [&random] {
    const double x = random.fraction(), y = random.fraction(), z = random.fraction();
    return Place{box_m * Eigen::Vector3d(x, y, z), random.orientation()};
  };
}

std::vector<Place> filled_places(const Placement& placement, std::size_t count, std::uint64_t seed = 1) {
  RandomNumbers random(seed);
  return placement.fill(count, drawing_places(random));
}

TEST(Placement, FillsARoomWithoutOverlap) {
  const Placement placement(dumb_bell(), channel_room(0.5));
  const std::vector<Place> places = filled_places(placement, 300);
  ASSERT_EQ(places.size(), 300U);
  EXPECT_TRUE(placement.touches(places).empty());
  for (const Place& place : places) EXPECT_TRUE(placement.holds(place));
}

TEST(Placement, KeepsWhatWasPlacedWhenMoreIsAdded) {
  const Placement placement(dumb_bell(), channel_room(0.0));
  const std::vector<Place> few = filled_places(placement, 20), many = filled_places(placement, 900);
  ASSERT_EQ(many.size(), 900U);
  for (std::size_t i = 0; i < few.size(); ++i) {
    EXPECT_EQ(few[i].center_m, many[i].center_m);
    EXPECT_EQ(few[i].orientation_wxyz, many[i].orientation_wxyz);
  }
  EXPECT_NE(filled_places(placement, 1, 2)[0].center_m, few[0].center_m);
}

TEST(Placement, EndsWhereNothingMoreHasRoom) {
  const std::size_t reached = filled_places(Placement(dumb_bell(), channel_room(0.0)), 2500).size();
  const double fraction = static_cast<double>(reached) * 8.38 / (box_m * box_m * box_m);
  EXPECT_GT(fraction, 0.18);  // random sequential addition of spheres jams at 0.384
  EXPECT_LT(fraction, 0.39);
}

TEST(Placement, FindsTouchesAcrossPeriodicFacesAndWithObstacles) {
  Room room = channel_room(0.5);
  room.obstacles.resize(1);
  room.obstacles[0].shape.radius_m = 3.0;
  room.obstacles[0].position_m = Eigen::Vector3d(20, 20, 20);
  const Placement placement(dumb_bell(), room);
  const std::vector<Place> places{{Eigen::Vector3d(10, 10, 2), {1, 0, 0, 0}},
                                  {Eigen::Vector3d(10, 12.25, 38), {1, 0, 0, 0}},  // its upper ball is at the face
                                  {Eigen::Vector3d(20, 24.25, 18), {1, 0, 0, 0}}};
  const std::vector<Touch> touches = placement.touches(places);
  ASSERT_EQ(touches.size(), 2U);
  EXPECT_EQ(touches[0].first, -1);
  EXPECT_EQ(touches[0].second, 2);
  EXPECT_NEAR(touches[0].distance_m, 0.25, 1e-12);
  EXPECT_EQ(touches[1].first, 0);
  EXPECT_EQ(touches[1].second, 1);
  EXPECT_NEAR(touches[1].distance_m, 0.25, 1e-12);
  EXPECT_TRUE(placement.touches({places[0], places[1]}, 2).empty());
  EXPECT_TRUE(placement.holds(places[1]));
  EXPECT_FALSE(placement.holds({Eigen::Vector3d(10, 0.9, 20), {1, 0, 0, 0}}));
}

TEST(Placement, SpreadsALatticeOverTheBox) {
  const Eigen::Vector3d low(10, 0, 0), high(20, 40, 20);
  const std::vector<Eigen::Vector3d> full = lattice_of(64, low, high, Eigen::Vector3d::Ones());
  std::set<std::tuple<double, double, double>> known;
  for (const Eigen::Vector3d& centre : full) known.emplace(centre.x(), centre.y(), centre.z());
  EXPECT_EQ(known.size(), 64U);  // 2 × 8 × 4 cells of 5 × 5 × 5
  EXPECT_EQ(full.front(), Eigen::Vector3d(12.5, 2.5, 2.5));
  EXPECT_EQ(full.back(), Eigen::Vector3d(17.5, 37.5, 17.5));
  const std::vector<Eigen::Vector3d> long_cells = lattice_of(8, low, high, Eigen::Vector3d(1, 8, 1));
  EXPECT_EQ(long_cells[1] - long_cells[0], Eigen::Vector3d(5, 0, 0));
  EXPECT_EQ(long_cells.back(), Eigen::Vector3d(17.5, 20, 17.5));                           // 2 × 1 × 4
  const Eigen::Vector3d last = lattice_of(50, low, high, Eigen::Vector3d::Ones()).back();  // of 2 × 7 × 4 cells
  EXPECT_TRUE(last.isApprox(Eigen::Vector3d(12.5, 40 - 20.0 / 7, 17.5)));
}

}  // namespace
}  // namespace copepod::coupler
