#include "lattice_boltzmann/bodies/refill_formula.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

using Neighbour = EquilibriumRefill::Neighbour;

double sum(const Populations& f) {
  double total = 0.0;
  for (const double value : f) total += value;
  return total;
}

TEST(EquilibriumRefill, TakesTheMeanDensityOfTheNeighboursAndTheVelocityOfTheSurface) {
  const Eigen::Vector3d u(0.02, -0.01, 0.03);
  const std::vector<Neighbour> neighbours = {{0.01}, {0.02}, {0.06}};
  const Populations f = EquilibriumRefill::fill(neighbours, u);
  EXPECT_NEAR(sum(f), 0.03, 1e-16);
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (std::size_t alpha = 0; alpha < 19; ++alpha)
    momentum += f[alpha] * Eigen::Vector3d(d3q19::e[alpha][0], d3q19::e[alpha][1], d3q19::e[alpha][2]);
  EXPECT_NEAR((momentum - 1.03 * u).norm(), 0.0, 1e-16);
}

TEST(EquilibriumRefill, WithoutNeighboursHasTheDensityOfTheFluidAtRest) {
  const Populations f = EquilibriumRefill::fill({}, Eigen::Vector3d::Zero());
  for (const double value : f) EXPECT_EQ(value, 0.0);
}

TEST(EquilibriumRefill, DescribesANeighbourByItsExcessDensity) {
  const Neighbour neighbour = EquilibriumRefill::describe([](int alpha) { return 0.001 * (alpha + 1); });
  EXPECT_NEAR(neighbour[0], 0.19, 1e-15);
}

}  // namespace
}  // namespace copepod::fluid
