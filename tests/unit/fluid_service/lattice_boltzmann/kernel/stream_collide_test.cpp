#include "lattice_boltzmann/kernel/stream_collide.hpp"

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

namespace copepod::fluid {
namespace {

template <class T>
std::vector<T> random_populations(const PopulationLayout& layout) {
  std::mt19937 generator(7);
  std::uniform_real_distribution<double> distribution(-1e-2, 1e-2);
  std::vector<T> values(static_cast<std::size_t>(layout.values()));
  for (T& value : values) value = static_cast<T>(distribution(generator));
  return values;
}

/// Two steps of a block whose rows do not divide by the vector width.
template <class T>
std::vector<T> two_steps(StreamCollide<T> update, const std::vector<Box>& regions, const Eigen::Vector3d& force) {
  const PopulationLayout layout(Box{{0, 0, 0}, {5, 4, 29}}, sizeof(T));
  std::vector<T> values = random_populations<T>(layout);
  const auto constants = collision_constants<T>(CollisionKind::trt, 0.7, force);
  for (const Placement placement : {Placement::home, Placement::streamed})
    for (const Box& region : regions)
      update(values.data(), layout, placement, region, constants, !force.isZero(0.0), nullptr);
  return values;
}

template <class T>
class StreamCollideKernel : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(StreamCollideKernel, Precisions);

TYPED_TEST(StreamCollideKernel, GivesTheSameBitsForEveryInstructionSet) {
  const StreamCollide<TypeParam> wide = stream_collide_avx2<TypeParam>();
  if (wide == nullptr) GTEST_SKIP() << "this machine has no AVX2";
  const StreamCollide<TypeParam> widest = stream_collide_avx512<TypeParam>();
  const std::vector<Box> whole = {{{0, 0, 0}, {5, 4, 29}}};
  for (const Eigen::Vector3d& force : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1e-4, 2e-4, -3e-4)}) {
    const auto expected = two_steps(stream_collide_baseline<TypeParam>(), whole, force);
    EXPECT_EQ(two_steps(wide, whole, force), expected);
    if (widest != nullptr) {
      EXPECT_EQ(two_steps(widest, whole, force), expected);
    }
  }
}

TYPED_TEST(StreamCollideKernel, GivesTheSameBitsInVectorBodyAndRemainder) {
  const std::vector<Box> whole = {{{0, 0, 0}, {5, 4, 29}}};
  const std::vector<Box> pieces = {{{0, 0, 0}, {5, 4, 3}}, {{0, 0, 3}, {2, 4, 29}}, {{2, 0, 3}, {5, 4, 29}}};
  const auto update = choose_stream_collide<TypeParam>().update;
  EXPECT_EQ(two_steps(update, whole, Eigen::Vector3d::Zero()), two_steps(update, pieces, Eigen::Vector3d::Zero()));
}

TYPED_TEST(StreamCollideKernel, LeavesTheMomentsOfTheCellsItUpdated) {
  const PopulationLayout layout(Box{{0, 0, 0}, {5, 4, 29}}, sizeof(TypeParam));
  const Box region{{1, 0, 2}, {4, 3, 29}};
  const auto cells = static_cast<std::size_t>(region.volume());
  const auto constants = collision_constants<TypeParam>(CollisionKind::trt, 0.7, Eigen::Vector3d::Zero());
  for (const auto update :
       {stream_collide_baseline<TypeParam>(), stream_collide_avx2<TypeParam>(), stream_collide_avx512<TypeParam>()}) {
    if (update == nullptr) continue;
    std::vector<TypeParam> values = random_populations<TypeParam>(layout);
    for (const Placement placement : {Placement::home, Placement::streamed}) {
      std::vector<double> moments_found(4 * cells);
      double* const found = moments_found.data();
      const UpdatedMoments updated = {found, {found + cells, found + 2 * cells, found + 3 * cells}};
      update(values.data(), layout, placement, region, constants, false, &updated);
      std::size_t i = 0;
      for (std::int64_t x = 1; x < 4; ++x)
        for (std::int64_t y = 0; y < 3; ++y)
          for (std::int64_t z = 2; z < 29; ++z, ++i) {
            const Moments<double> m = moments(layout.gather(values.data(), layout.site(x, y, z), other(placement)));
            ASSERT_EQ(updated.excess_density[i], m.excess_density);
            for (std::size_t axis = 0; axis < 3; ++axis) ASSERT_EQ(updated.momentum[axis][i], m.momentum[axis]);
          }
    }
  }
}

TEST(Collision, LeavesAnEquilibriumAsItIs) {
  const double velocity[3] = {0.02, -0.03, 0.05};
  double g[d3q19::directions];
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) g[alpha] = equilibrium_deviation(alpha, 0.01, velocity);
  const std::vector<double> before(g, g + d3q19::directions);
  collide<false>(g, collision_constants<double>(CollisionKind::bgk, 0.8, Eigen::Vector3d::Zero()));
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    EXPECT_NEAR(g[alpha], before[static_cast<std::size_t>(alpha)], 1e-16);
}

TEST(Collision, ConservesMassAndAddsTheForceToTheMomentum) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> distribution(-1e-2, 1e-2);
  const Eigen::Vector3d force(1e-4, -2e-4, 3e-4);
  double g[d3q19::directions];
  for (double& value : g) value = distribution(generator);
  const Moments<double> before = moments(g);
  collide<true>(g, collision_constants<double>(CollisionKind::trt, 0.6, force));
  const Moments<double> after = moments(g);
  EXPECT_NEAR(after.excess_density, before.excess_density, 1e-16);
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(after.momentum[axis] - before.momentum[axis], force[axis], 1e-16);
}

// With equal rates the pairwise form must be the paper's eq. (3), population by population.
TEST(Collision, IsThePapersBgkForEqualRates) {
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> distribution(-1e-2, 1e-2);
  const double relaxation_time = 2.0 / 3.0;
  double g[d3q19::directions];
  for (double& value : g) value = distribution(generator);
  const Moments<double> m = moments(g);
  const double density = 1.0 + m.excess_density;
  const double velocity[3] = {m.momentum[0] / density, m.momentum[1] / density, m.momentum[2] / density};
  double expected[d3q19::directions];
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    expected[alpha] =
        g[alpha] - (g[alpha] - equilibrium_deviation(alpha, m.excess_density, velocity)) / relaxation_time;
  collide<false>(g, collision_constants<double>(CollisionKind::bgk, relaxation_time, Eigen::Vector3d::Zero()));
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) EXPECT_NEAR(g[alpha], expected[alpha], 1e-16) << alpha;
}

}  // namespace
}  // namespace copepod::fluid
