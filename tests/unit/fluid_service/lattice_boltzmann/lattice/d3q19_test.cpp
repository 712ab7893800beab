#include "lattice_boltzmann/lattice/d3q19.hpp"

#include <gtest/gtest.h>

#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {
namespace {

TEST(D3Q19, OppositeDirectionsAreNeighboursInTheList) {
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_EQ(d3q19::e[d3q19::opposite(alpha)][axis], -d3q19::e[alpha][axis]) << alpha;
}

// Isotropy up to fourth order is what makes the Navier-Stokes equations come out [Qian et al. 1992].
TEST(D3Q19, WeightsHaveTheMomentsOfTheMaxwellian) {
  double zeroth = 0.0;
  double second[3][3] = {};
  double fourth[3][3] = {};  // Σ w e_a² e_b²
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
    const double w = d3q19::weight(alpha);
    const auto& e = d3q19::e[alpha];
    zeroth += w;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        second[a][b] += w * e[a] * e[b];
        fourth[a][b] += w * e[a] * e[a] * e[b] * e[b];
      }
  }
  EXPECT_NEAR(zeroth, 1.0, 1e-15);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) {
      EXPECT_NEAR(second[a][b], a == b ? 1.0 / 3.0 : 0.0, 1e-15);
      EXPECT_NEAR(fourth[a][b], a == b ? 1.0 / 3.0 : 1.0 / 9.0, 1e-15);
    }
}

TEST(D3Q19, MirroringTwiceGivesTheDirectionBack) {
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    for (int axis = 0; axis < 3; ++axis) EXPECT_EQ(d3q19::mirrored(d3q19::mirrored(alpha, axis), axis), alpha);
}

TEST(PopulationLayout, SlotsThatACellReadsAreThoseThatItWrites) {
  const PopulationLayout layout(Box{{0, 0, 0}, {4, 5, 6}}, 8);
  const std::int64_t cell = layout.cell(2, 2, 2);
  const auto at = [](std::int64_t index) { return Site{index, 0}; };
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
    const int back = d3q19::opposite(alpha);
    // From home: what arrives in direction ᾱ left the neighbour x + e_α; it is read where f̃_α goes.
    EXPECT_EQ(layout.location(at(cell + layout.neighbour(alpha)), back, Placement::home),
              layout.location(at(cell), alpha, Placement::streamed));
    // From streamed: what arrives in direction α lies at x, where f̃_ᾱ goes.
    EXPECT_EQ(layout.location(at(cell - layout.neighbour(alpha)), alpha, Placement::streamed),
              layout.location(at(cell), back, Placement::home));
  }
}

TEST(PopulationLayout, InteriorRowsStartOnACacheLine) {
  for (const int value_bytes : {4, 8}) {
    const PopulationLayout layout(Box{{3, 4, 5}, {10, 12, 14}}, value_bytes);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      EXPECT_EQ((layout.slot(alpha) + layout.cell(2, 3, 0)) * value_bytes % 64, 0);
  }
}

}  // namespace
}  // namespace copepod::fluid
