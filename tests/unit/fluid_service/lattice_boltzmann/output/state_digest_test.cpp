#include "lattice_boltzmann/output/state_digest.hpp"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include "lattice_boltzmann/output/population_file.hpp"

namespace copepod::fluid {
namespace {

/// 19 different values per cell that depend on the cell only.
std::vector<double> populations_of(const Box& box) {
  std::vector<double> values;
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x)
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z)
        for (int q = 0; q < 19; ++q) values.push_back(static_cast<double>(1000 * x + 100 * y + 10 * z + q));
  return values;
}

std::uint64_t digest_of_box(const Cell& cells, const Box& box) {
  const std::vector<double> values = populations_of(box);
  return digest_of_populations<double>(cells, box, values);
}

TEST(StateDigest, IsTheSameForEveryDecomposition) {
  const Cell cells = {4, 3, 5};
  const std::uint64_t whole = digest_of_box(cells, {{0, 0, 0}, cells});
  const std::uint64_t parts = digest_of_box(cells, {{0, 0, 0}, {4, 3, 2}}) +
                              digest_of_box(cells, {{0, 0, 2}, {1, 3, 5}}) +
                              digest_of_box(cells, {{1, 0, 2}, {4, 3, 5}});
  EXPECT_EQ(parts, whole);
}

TEST(StateDigest, SeesTwoCellsExchanged) {
  const Cell cells = {1, 1, 2};
  std::vector<double> values = populations_of({{0, 0, 0}, cells});
  const std::uint64_t before = digest_of_populations<double>(cells, {{0, 0, 0}, cells}, values);
  std::swap_ranges(values.begin(), values.begin() + 19, values.begin() + 19);
  EXPECT_NE(digest_of_populations<double>(cells, {{0, 0, 0}, cells}, values), before);
}

TEST(CaseDigest, ChangesWithThePhysicsButNotWithTheOutput) {
  FluidSetup setup;
  setup.bodies.resize(2);
  const std::uint64_t original = digest_of(setup);
  setup.fields.every_steps = 100;
  setup.fields.directory = "/elsewhere";
  EXPECT_EQ(digest_of(setup), original);
  setup.bodies[1].radius_m = 1e-6;
  EXPECT_NE(digest_of(setup), original);
  setup.bodies[1].radius_m = 0.0;
  setup.boundaries[5].kind = BoundaryKind::periodic;
  EXPECT_NE(digest_of(setup), original);
}

}  // namespace
}  // namespace copepod::fluid
