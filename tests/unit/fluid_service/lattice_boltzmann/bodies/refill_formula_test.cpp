#include <random>

#include <gtest/gtest.h>

#include "lattice_boltzmann/bodies/refill.hpp"

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
  const Populations f = EquilibriumRefill::fill({0.03}, u);
  EXPECT_NEAR(sum(f), 0.03, 1e-16);
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
  for (std::size_t alpha = 0; alpha < 19; ++alpha)
    momentum += f[alpha] * Eigen::Vector3d(d3q19::e[alpha][0], d3q19::e[alpha][1], d3q19::e[alpha][2]);
  EXPECT_NEAR((momentum - 1.03 * u).norm(), 0.0, 1e-16);
}

TEST(EquilibriumRefill, DescribesANeighbourByItsExcessDensity) {
  Populations f;
  for (std::size_t alpha = 0; alpha < f.size(); ++alpha) f[alpha] = 0.001 * static_cast<double>(alpha + 1);
  EXPECT_NEAR(EquilibriumRefill::describe(f)[0], 0.19, 1e-15);
}

/// Populations of a sheared flow after the collision: equilibrium and a part −a w_α (e_x e_y + ghost).
Populations sheared(double amplitude, double ghost) {
  Populations f = equilibrium(0.02, {0.03, -0.01, 0.02});
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
    const auto& e = d3q19::e[alpha];
    const double third = e[0] * (e[1] * e[1] - e[2] * e[2]);  // a moment without a part in the Navier-Stokes equations
    f[static_cast<std::size_t>(alpha)] += d3q19::weight(alpha) * (amplitude * e[0] * e[1] + ghost * third);
  }
  return f;
}

TEST(NonequilibriumRefill, GivesBackACellThatIsLikeItsNeighbours) {
  const Populations f = sheared(1e-3, 1e-4);
  const Populations filled = NonequilibriumRefill::fill(NonequilibriumRefill::describe(f), {0.03, -0.01, 0.02});
  for (std::size_t alpha = 0; alpha < f.size(); ++alpha) EXPECT_NEAR(filled[alpha], f[alpha], 1e-16);
}

TEST(GradRefill, KeepsTheStressAndDropsHigherMoments) {
  const Populations expected = sheared(1e-3, 0.0);
  const Populations filled = GradRefill::fill(GradRefill::describe(sheared(1e-3, 1e-4)), {0.03, -0.01, 0.02});
  for (std::size_t alpha = 0; alpha < expected.size(); ++alpha) EXPECT_NEAR(filled[alpha], expected[alpha], 1e-16);
}

template <class Formula>
class EveryRefill : public testing::Test {};
using Formulas = testing::Types<EquilibriumRefill, NonequilibriumRefill, GradRefill>;
TYPED_TEST_SUITE(EveryRefill, Formulas);

TYPED_TEST(EveryRefill, GivesTheMirrorImageOfACellToItsMirrorImage) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-0.01, 0.01);
  for (int repeat = 0; repeat < 100; ++repeat) {
    Populations f;
    for (double& population : f) population = number(random);
    const Eigen::Vector3d u(number(random), number(random), number(random));
    const Populations filled = TypeParam::fill(TypeParam::describe(f), u);
    for (int axis = 0; axis < 3; ++axis) {
      Populations image;
      for (int alpha = 0; alpha < d3q19::directions; ++alpha)
        image[static_cast<std::size_t>(d3q19::mirrored(alpha, axis))] = f[static_cast<std::size_t>(alpha)];
      Eigen::Vector3d image_u = u;
      image_u[axis] *= -1.0;
      const Populations filled_image = TypeParam::fill(TypeParam::describe(image), image_u);
      for (int alpha = 0; alpha < d3q19::directions; ++alpha)
        EXPECT_EQ(filled_image[static_cast<std::size_t>(d3q19::mirrored(alpha, axis))],
                  filled[static_cast<std::size_t>(alpha)]);
    }
  }
}

}  // namespace
}  // namespace copepod::fluid
