#include "lattice_boltzmann/output/population_file.hpp"

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

/// Of two cells one above the other, with populations that count from `first`.
std::uint64_t digest_of_cells(double first_of_lower, double first_of_upper) {
  const Cell cells = {1, 1, 2};
  return digest_of_cell(cells, {0, 0, 0}, [&](int alpha) { return first_of_lower + alpha; }) +
         digest_of_cell(cells, {0, 0, 1}, [&](int alpha) { return first_of_upper + alpha; });
}

TEST(CellDigest, SeesTwoCellsExchanged) { EXPECT_NE(digest_of_cells(0.0, 19.0), digest_of_cells(19.0, 0.0)); }

TEST(CellDigest, SeesTwoDirectionsExchanged) {
  const auto digest = [](int a, int b) {
    return digest_of_cell(Cell{1, 1, 1}, Cell{0, 0, 0}, [&](int alpha) {
      return alpha == a ? 1.0 : alpha == b ? 2.0 : 0.0;
    });
  };
  EXPECT_NE(digest(3, 4), digest(4, 3));
}

TEST(LayoutDigest, ChangesWithWhatPopulationsBelongTo) {
  FluidSetup setup;
  setup.bodies.resize(2);
  const std::uint64_t original = layout_digest(setup);
  setup.fields.every_steps = 100;
  setup.fields.directory = "/elsewhere";
  EXPECT_EQ(layout_digest(setup), original);
  setup.bodies[1].radius_m = 1e-6;
  EXPECT_NE(layout_digest(setup), original);
  setup.bodies[1].radius_m = 0.0;
  setup.boundaries[5].kind = BoundaryKind::periodic;
  setup.collision = CollisionKind::trt;
  EXPECT_EQ(layout_digest(setup), original);
  setup.step_s = 1.0;
  EXPECT_NE(layout_digest(setup), original);
}

}  // namespace
}  // namespace copepod::fluid
