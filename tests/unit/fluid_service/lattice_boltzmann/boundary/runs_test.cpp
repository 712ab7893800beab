#include <gtest/gtest.h>

#include "lattice_boltzmann/boundary/wall.hpp"

namespace copepod::fluid {
namespace {

std::vector<int> places_of(const Runs& runs, std::size_t size) {
  std::vector<int> array(size);
  for (std::size_t i = 0; i < size; ++i) array[i] = static_cast<int>(i);
  std::vector<int> places;
  runs.for_each(array.data(), [&](int place) { places.push_back(place); });
  return places;
}

TEST(Runs, PlacesOfEqualStrideAreOneRun) {
  Runs runs;
  for (int i = 0; i < 4; ++i) runs.add(10 + i);
  for (int i = 0; i < 3; ++i) runs.add(20 + 5 * i);
  for (int i = 0; i < 3; ++i) runs.add(9 - i);
  EXPECT_EQ(runs.runs().size(), 3U);
  EXPECT_EQ(runs.values(), 10);
  EXPECT_EQ(places_of(runs, 31), (std::vector<int>{10, 11, 12, 13, 20, 25, 30, 9, 8, 7}));
}

TEST(Runs, VisitPlacesInTheOrderInWhichTheyWereAdded) {
  Runs runs;
  const std::vector<int> places = {3, 3, 4, 9, 1, 7, 0};
  for (const int place : places) runs.add(place);
  EXPECT_EQ(places_of(runs, 10), places);
}

}  // namespace
}  // namespace copepod::fluid
