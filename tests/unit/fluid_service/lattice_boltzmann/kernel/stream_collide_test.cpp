#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/kernel/exchange_group.hpp"
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
std::vector<T> two_steps(StreamCollide<T> update, const std::vector<Box>& regions, const Eigen::Vector3d& force,
                         CollisionKind collision) {
  const PopulationLayout layout(Box{{0, 0, 0}, {5, 4, 29}}, sizeof(T));
  std::vector<T> values = random_populations<T>(layout);
  const auto constants = collision_constants<T>(collision, 0.7, force);
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
  const StreamCollide<TypeParam> wide = avx2_kernels<TypeParam>().stream_collide;
  if (wide == nullptr) GTEST_SKIP() << "this machine has no AVX2";
  const StreamCollide<TypeParam> widest = avx512_kernels<TypeParam>().stream_collide;
  const std::vector<Box> whole = {{{0, 0, 0}, {5, 4, 29}}};
  for (const Eigen::Vector3d& force : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1e-4, 2e-4, -3e-4)})
    for (const CollisionKind collision : {CollisionKind::trt, CollisionKind::central_moments}) {
      const auto expected = two_steps(baseline_kernels<TypeParam>().stream_collide, whole, force, collision);
      EXPECT_EQ(two_steps(wide, whole, force, collision), expected);
      if (widest != nullptr) {
        EXPECT_EQ(two_steps(widest, whole, force, collision), expected);
      }
    }
}

TYPED_TEST(StreamCollideKernel, GivesTheSameBitsInVectorBodyAndRemainder) {
  const std::vector<Box> whole = {{{0, 0, 0}, {5, 4, 29}}};
  const std::vector<Box> pieces = {{{0, 0, 0}, {5, 4, 3}}, {{0, 0, 3}, {2, 4, 29}}, {{2, 0, 3}, {5, 4, 29}}};
  const auto update = choose_kernels<TypeParam>().stream_collide;
  for (const CollisionKind collision : {CollisionKind::trt, CollisionKind::central_moments})
    EXPECT_EQ(two_steps(update, whole, Eigen::Vector3d::Zero(), collision),
              two_steps(update, pieces, Eigen::Vector3d::Zero(), collision));
}

/// Two links of every third cell of a block's rows but the first one.
template <class T>
struct BoundaryCells {
  explicit BoundaryCells(const Box& block) : rows(static_cast<std::size_t>(block.extent(0) * block.extent(1))) {
    for (std::size_t row = 1; row < rows.size(); ++row) {
      rows[row] = {.first_link = static_cast<std::uint32_t>(links.size()),
                   .first_cell = static_cast<std::uint32_t>(z.size())};
      for (std::int64_t at = static_cast<std::int64_t>(row) % 3; at < block.extent(2); at += 3) {
        for (const std::uint32_t alpha : {1U + static_cast<std::uint32_t>(at) % 9U, 18U})
          links.push_back(static_cast<LinkInRow>(at) << direction_bits | alpha), ++rows[row].links;
        z.push_back(static_cast<std::int32_t>(at)), ++rows[row].cells;
      }
    }
    by_link.resize(links.size() * per_link);
    for (std::size_t i = 0; i < links.size(); ++i) of_link(i)[Values::crossing] = static_cast<T>(0.01 * std::sin(i));
    by_cell.resize(z.size() * per_cell);
  }
  RowsBesideBodies<T> view() { return {rows.data(), links.data(), z.data(), by_link.data(), by_cell.data(), true}; }
  T* of_link(std::size_t link) { return by_link.data() + per_link * link; }
  double* of_cell(std::size_t cell) { return by_cell.data() + per_cell * cell; }

  using Values = BoundaryValues<T>;
  static constexpr std::size_t per_link = Values::per_link(true);
  static constexpr std::size_t per_cell = Values::per_cell(true);
  std::vector<BoundaryRow> rows;
  std::vector<LinkInRow> links;
  std::vector<std::int32_t> z;
  std::vector<T> by_link;
  std::vector<double> by_cell;
};

TYPED_TEST(StreamCollideKernel, PutsBackWhatReturnsAndCollectsWhatLeaves) {
  using Values = BoundaryValues<TypeParam>;
  const PopulationLayout layout(Box{{0, 0, 0}, {5, 4, 157}}, sizeof(TypeParam));
  const Box region{{1, 0, 2}, {4, 3, 156}};
  const auto constants = collision_constants<TypeParam>(CollisionKind::trt, 0.7, Eigen::Vector3d::Zero());
  for (const auto update : {baseline_kernels<TypeParam>().stream_collide, avx2_kernels<TypeParam>().stream_collide,
                            avx512_kernels<TypeParam>().stream_collide}) {
    if (update == nullptr) continue;
    std::vector<TypeParam> found = random_populations<TypeParam>(layout);
    std::vector<TypeParam> expected = found;
    for (const Placement placement : {Placement::home, Placement::streamed}) {
      BoundaryCells<TypeParam> cells(layout.block());
      BoundaryCells<TypeParam> before = cells;
      const auto for_each_link = [&](const auto& visit) {
        for (std::size_t row = 0; row < cells.rows.size(); ++row)
          for (std::uint32_t i = cells.rows[row].first_link; i < cells.rows[row].first_link + cells.rows[row].links;
               ++i) {
            const Cell cell = {static_cast<std::int64_t>(row) / 4, static_cast<std::int64_t>(row) % 4,
                               z_of(cells.links[i])};
            visit(i, layout.site(cell), static_cast<int>(direction_of(cells.links[i])), region.contains(cell));
          }
      };
      for_each_link([&](std::size_t i, const Site& site, int alpha, bool inside) {
        const std::int64_t read_at = layout.entry(site, d3q19::opposite(alpha), placement);
        if (inside) expected[static_cast<std::size_t>(read_at)] = cells.of_link(i)[Values::crossing];
      });
      const RowsBesideBodies<TypeParam> view = cells.view();
      update(found.data(), layout, placement, region, constants, false, &view);
      update(expected.data(), layout, placement, region, constants, false, nullptr);
      ASSERT_EQ(found, expected);
      for_each_link([&](std::size_t i, const Site& site, int alpha, bool inside) {
        const auto f = [&](int direction) {
          return expected[static_cast<std::size_t>(layout.location(site, direction, other(placement)))];
        };
        ASSERT_EQ(cells.of_link(i)[Values::crossing], inside ? f(alpha) : before.of_link(i)[Values::crossing]);
        ASSERT_EQ(cells.of_link(i)[Values::inward], inside ? f(d3q19::opposite(alpha)) : TypeParam(0));
        const Moments<double> m = moments(layout.gather(expected.data(), site, other(placement)));
        const double* const of_cell = cells.of_cell(i / 2);
        ASSERT_EQ(of_cell[Values::excess_density], inside ? m.excess_density : 0.0);
        for (std::size_t axis = 0; axis < 3; ++axis)
          ASSERT_EQ(of_cell[Values::momentum + axis], inside ? m.momentum[axis] : 0.0);
      });
    }
  }
}

TEST(Collision, LeavesAnEquilibriumAsItIs) {
  const double velocity[3] = {0.02, -0.03, 0.05};
  double g[d3q19::directions];
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) g[alpha] = equilibrium_deviation(alpha, 0.01, velocity);
  const std::vector<double> before(g, g + d3q19::directions);
  collide<CollisionForm{false, false}>(g,
                                       collision_constants<double>(CollisionKind::bgk, 0.8, Eigen::Vector3d::Zero()));
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
  collide<CollisionForm{false, true}>(g, collision_constants<double>(CollisionKind::trt, 0.6, force));
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
  collide<CollisionForm{false, false}>(
      g, collision_constants<double>(CollisionKind::bgk, relaxation_time, Eigen::Vector3d::Zero()));
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) EXPECT_NEAR(g[alpha], expected[alpha], 1e-16) << alpha;
}

/// Σ f (e − u)_x^p (e − u)_y^q (e − u)_z^r
double central_moment(const double (&g)[d3q19::directions], const Eigen::Vector3d& u, int p, int q, int r) {
  double sum = 0.0;
  for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
    const auto& e = d3q19::e[alpha];
    sum += (g[alpha] + d3q19::weight(alpha)) * std::pow(e[0] - u.x(), p) * std::pow(e[1] - u.y(), q) *
           std::pow(e[2] - u.z(), r);
  }
  return sum;
}

// Moments by their definition, before and after; u² F and u⁴ are what the collision leaves out.
TEST(Collision, RelaxesCentralMoments) {
  std::mt19937 generator(11);
  std::uniform_real_distribution<double> distribution(-2e-3, 2e-3);
  for (const Eigen::Vector3d& force : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1e-5, -2e-5, 3e-5)}) {
    double g[d3q19::directions];
    for (double& value : g) value = distribution(generator);
    double before[d3q19::directions];
    std::ranges::copy(g, before);
    const double tau = 0.6;
    const auto constants = collision_constants<double>(CollisionKind::central_moments, tau, force);
    force.isZero(0.0) ? collide<CollisionForm{true, false}>(g, constants)
                      : collide<CollisionForm{true, true}>(g, constants);
    const Moments<double> m = moments(before);
    const double density = 1.0 + m.excess_density;
    const Eigen::Vector3d u = (m.momentum_vector() + 0.5 * force) / density;
    EXPECT_GT(u.norm(), 0.002);
    const double tolerance = force.isZero(0.0) ? 1e-16 : 2e-9;
    EXPECT_NEAR(moments(g).excess_density, m.excess_density, 1e-16);
    EXPECT_LT((moments(g).momentum_vector() - m.momentum_vector() - force).norm(), 1e-16);
    const auto second = [&](const double(&f)[d3q19::directions], int a, int b) {
      return central_moment(f, u, (a == 0) + (b == 0), (a == 1) + (b == 1), (a == 2) + (b == 2));
    };
    const double trace = second(before, 0, 0) + second(before, 1, 1) + second(before, 2, 2);
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        const double kept = (1.0 - 1.0 / tau) * (second(before, a, b) - (a == b ? trace / 3.0 : 0.0));
        EXPECT_NEAR(second(g, a, b), kept + (a == b ? density / 3.0 : 0.0), 1e-15) << a << b;
        if (a == b) continue;
        EXPECT_NEAR(central_moment(g, u, 2 * (a == 0) + (b == 0), 2 * (a == 1) + (b == 1), 2 * (a == 2) + (b == 2)),
                    force[b] / 6.0, tolerance);
        double fourth = -1.0 / 9.0;  // M_aabb
        for (int alpha = 0; alpha < d3q19::directions; ++alpha)
          fourth += (g[alpha] + d3q19::weight(alpha)) * std::pow(d3q19::e[alpha][a] * d3q19::e[alpha][b], 2);
        const double excess = m.excess_density;
        const double pair = second(g, a, a) + second(g, b, b) + density * (u[a] * u[a] + u[b] * u[b]) +
                            u[a] * force[a] + u[b] * force[b] - 2.0 / 3.0;
        EXPECT_NEAR(fourth, (pair - excess / 3.0) / 3.0, 1e-16);
      }
  }
}

TEST(Collision, TreatsMirrorImagesAlike) {
  std::mt19937 generator(13);
  std::uniform_real_distribution<double> distribution(-1e-2, 1e-2);
  const auto constants = collision_constants<double>(CollisionKind::central_moments, 0.51, Eigen::Vector3d::Zero());
  for (int axis = 0; axis < 3; ++axis) {
    const auto image = [&](int alpha) {
      auto e = d3q19::e[alpha];
      e[static_cast<std::size_t>(axis)] *= -1;
      for (int other = 0; other < d3q19::directions; ++other)
        if (d3q19::e[other] == e) return other;
      return -1;
    };
    double g[d3q19::directions];
    double mirrored[d3q19::directions];
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) g[alpha] = distribution(generator);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) mirrored[image(alpha)] = g[alpha];
    collide<CollisionForm{true, false}>(g, constants);
    collide<CollisionForm{true, false}>(mirrored, constants);
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) EXPECT_EQ(mirrored[image(alpha)], g[alpha]) << axis;
  }
}

}  // namespace
}  // namespace copepod::fluid
