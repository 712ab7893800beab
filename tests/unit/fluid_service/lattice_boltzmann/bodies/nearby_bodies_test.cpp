#include "lattice_boltzmann/bodies/nearby_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "ranks/thread_ranks.hpp"

namespace copepod::fluid {
namespace {

FluidSetup box(const Cell& cells, const std::array<BoundaryKind, 3>& faces, std::vector<Shape> bodies) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.domain_cells = cells;
  for (std::size_t face = 0; face < 6; ++face) setup.boundaries[face].kind = faces[face / 2];
  setup.bodies = std::move(bodies);
  return setup;
}

constexpr auto periodic = BoundaryKind::periodic;
constexpr auto mirror = BoundaryKind::free_slip;
constexpr auto wall = BoundaryKind::no_slip;

/// Positions in all of the domain, and of periodic images, and directions.
class RandomPlaces {
 public:
  explicit RandomPlaces(const Domain& domain) : domain_(domain) {}
  Eigen::Vector3d position() {
    Eigen::Vector3d result;
    for (int axis = 0; axis < 3; ++axis) {
      const double beyond = domain_.periodic(axis) ? 1.5 : 0.0;
      result[axis] = std::uniform_real_distribution(-beyond, 1.0 + beyond)(generator_) *
                     static_cast<double>(domain_.cells()[axis]);
    }
    return result;
  }
  Eigen::Vector3d direction() {
    std::normal_distribution<double> normal;
    return Eigen::Vector3d(normal(generator_), normal(generator_), normal(generator_)).normalized();
  }

 private:
  const Domain& domain_;
  std::mt19937 generator_{7};
};

/// Whether the body covers a cell of the block or its ghosts.
bool touches(const LatticeBody& body, const Domain& domain, const Box& block) {
  const PopulationLayout layout(block, sizeof(double));
  BodyMap map(domain, layout, {body});
  return map.update(std::vector<std::int32_t>{0});
}

/// Cells between the box around the body's bounding ball and the block, along the axis where it is furthest.
double distance(const LatticeBody& body, double bounding_radius, const Domain& domain, const Box& block) {
  double result = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    double nearest = std::numeric_limits<double>::infinity();
    for (std::int64_t index = block.low[axis]; index < block.high[axis]; ++index) {
      double away = static_cast<double>(index) + 0.5 - body.position[axis];
      if (domain.periodic(axis)) away = std::remainder(away, static_cast<double>(domain.cells()[axis]));
      nearest = std::min(nearest, std::abs(away) - 0.5);
    }
    result = std::max(result, nearest - bounding_radius);
  }
  return result;
}

struct Division {
  Cell cells{};
  std::array<BoundaryKind, 3> faces{};
  int ranks = 1;
};

class NearBlocksOf : public testing::TestWithParam<Division> {};

TEST_P(NearBlocksOf, AreAllThatABodyTouchesAndNoneThatIsFarAway) {
  const auto& [cells, faces, ranks] = GetParam();
  const FluidSetup setup = box(cells, faces,
                               {{ShapeKind::sphere, 1.7, 0.0},
                                {ShapeKind::capsule, 1.2, 2.5},
                                {.kind = ShapeKind::box, .extents_m = {3.0, 1.0, 4.0}}});
  const LatticeUnits units(setup);
  const Domain domain(setup, units);
  const BlockPartition partition(domain.cells(), ranks);
  const double film_reach = 3.0;  // more than the margin of covered cells
  const NearBlocks near_blocks(domain, partition, film_reach);
  RandomPlaces random(domain);
  int touched = 0;
  for (int sample = 0; sample < 60; ++sample)
    for (const Shape& shape : setup.bodies) {
      LatticeBody body(shape, setup.cell_size_m);
      body.place(random.position(), Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), random.direction()));
      std::vector<int> near;
      near_blocks.for_each_rank(near_blocks.around(body.position, bounding_radius_m(shape)).blocks, {},
                                [&](int rank) { near.push_back(rank); });
      EXPECT_EQ(std::set<int>(near.begin(), near.end()).size(), near.size()) << "a block is listed twice";
      for (int rank = 0; rank < ranks; ++rank) {
        const bool listed = std::ranges::find(near, rank) != near.end();
        const double away = distance(body, bounding_radius_m(shape), domain, partition.block(rank));
        if (touches(body, domain, partition.block(rank))) {
          ++touched;
          EXPECT_TRUE(listed) << "rank " << rank << ", body at " << body.position.transpose();
        }
        if (away < film_reach + 0.5) {  // a link ends half a cell beyond the block at most
          EXPECT_TRUE(listed) << "a film at rank " << rank << ", body at " << body.position.transpose();
        }
        if (away > film_reach + 3.0) {
          EXPECT_FALSE(listed) << "rank " << rank << ", body at " << body.position.transpose();
        }
      }
    }
  EXPECT_GT(touched, 100);
}

INSTANTIATE_TEST_SUITE_P(Divisions, NearBlocksOf,
                         testing::Values(Division{{21, 24, 18}, {periodic, periodic, periodic}, 8},
                                         Division{{40, 10, 9}, {periodic, wall, mirror}, 4},
                                         Division{{26, 27, 28}, {mirror, wall, periodic}, 27},
                                         Division{{33, 7, 7}, {wall, periodic, periodic}, 11}));

TEST(NearBlocks, HaveAPlaceForABodyThatHasNone) {
  const FluidSetup setup = box({20, 20, 20}, {periodic, wall, wall}, {});
  const LatticeUnits units(setup);
  const Domain domain(setup, units);
  const BlockPartition partition(domain.cells(), 4);
  const NearBlocks near_blocks(domain, partition, 0.0);
  const auto ranks_near = [&](double x, double y, double z) {
    int count = 0;
    near_blocks.for_each_rank(near_blocks.around({x, y, z}, 1.0).blocks, {}, [&](int rank) {
      EXPECT_GE(rank, 0);
      EXPECT_LT(rank, 4);
      ++count;
    });
    return count;
  };
  constexpr double huge = 1e300;
  constexpr double infinite = std::numeric_limits<double>::infinity();
  for (const double x : {5.0, -huge, huge, infinite, std::nan("")})
    for (const double y : {5.0, -3.0, 25.0, -huge, huge, infinite, std::nan("")}) EXPECT_GE(ranks_near(x, y, 5.0), 1);
}

/// Bodies that drift through a chain of blocks, and some that leap.
class Drift {
 public:
  static constexpr int bodies = 60;
  static FluidSetup setup(int ranks) {
    return box({6 * ranks, 8, 8}, {periodic, wall, wall},
               std::vector<Shape>(static_cast<std::size_t>(bodies), {ShapeKind::capsule, 1.0, 0.5}));
  }
  static Kinematics at(std::int64_t step, int ranks) {
    Kinematics kinematics;
    kinematics.step = step;
    kinematics.resize(bodies);
    for (Eigen::Index b = 0; b < bodies; ++b) {
      const auto i = static_cast<double>(b);
      const double speed = b % 5 == 0 ? 17.0 : 0.4;
      kinematics.position_m.col(b) << std::fmod(i * 1.37 + speed * static_cast<double>(step), 6.0 * ranks), 4.0, 4.0;
      kinematics.orientation_wxyz.col(b) << 1.0, i, 2.0, static_cast<double>(step);
      kinematics.velocity_m_per_s.col(b).setConstant(i);
      kinematics.angular_velocity_rad_per_s.col(b).setConstant(-i);
    }
    return kinematics;
  }
  /// What a rank finds to act on a body: for some of them more than 64 bits, for others only the sum over ranks.
  static LoadSums load(int rank, std::int32_t body, std::int64_t step) {
    LoadSums sums{};
    if (body % 7 == 3) return sums;
    for (std::size_t i = 0; i < sums.size(); ++i) {
      sums[i] = fixed_point::Sum{rank + 1} * (static_cast<int>(i) - 3) * (body + 1) * (step + 1);
      if (body % 3 == 0) sums[i] *= fixed_point::Sum{1} << 70;
      if (body % 3 == 1) sums[i] += std::numeric_limits<std::int64_t>::max() / (i % 2 == 0 ? 3 : -2) * 2;
    }
    return sums;
  }
};

/// Every rank: compares what it receives with the definition, and rank 0 the sums.
void follow_the_drift(Communicator& ranks) {
  const FluidSetup setup = Drift::setup(ranks.size());
  const LatticeUnits units(setup);
  const Domain domain(setup, units);
  const BlockPartition partition(domain.cells(), ranks.size());
  const NearBlocks near_blocks(domain, partition, 0.0);
  NearbyBodies nearby(setup, units, domain, partition, true, ranks);
  const auto near = [&](const Kinematics& kinematics, std::int32_t body) {
    std::set<int> result;
    near_blocks.for_each_rank(near_blocks.around(kinematics.position_m.col(body), 1.25).blocks, {},
                              [&](int rank) { result.insert(rank); });
    return result;
  };
  const auto hears_of = [&](std::int64_t step, std::int32_t body) {
    std::set<int> result = near(Drift::at(step, ranks.size()), body);
    if (step > 0) result.merge(near(Drift::at(step - 1, ranks.size()), body));
    return result;
  };
  std::vector<double> returned_mass(Drift::bodies);
  for (std::size_t b = 0; b < returned_mass.size(); ++b) returned_mass[b] = 0.5 * static_cast<double>(b);
  for (std::int64_t step = 0; step < 6; ++step) {
    const Kinematics all = Drift::at(step, ranks.size());
    nearby.scatter(ranks.rank() == 0 ? all : Kinematics{}, returned_mass);
    std::vector<std::int32_t> expected;
    for (std::int32_t b = 0; b < Drift::bodies; ++b)
      if (hears_of(step, b).contains(ranks.rank())) expected.push_back(b);
    EXPECT_EQ(nearby.bodies(), expected) << "rank " << ranks.rank() << " step " << step;
    std::vector<LoadSums> loads;
    for (std::size_t place = 0; place < nearby.bodies().size(); ++place) {
      const std::int32_t body = nearby.bodies()[place];
      const auto column = static_cast<Eigen::Index>(place);
      EXPECT_EQ(nearby.place_of(body), place);
      EXPECT_EQ(nearby.kinematics().position_m.col(column), all.position_m.col(body));
      EXPECT_EQ(nearby.kinematics().orientation_wxyz.col(column), all.orientation_wxyz.col(body));
      EXPECT_EQ(nearby.kinematics().velocity_m_per_s.col(column), all.velocity_m_per_s.col(body));
      EXPECT_EQ(nearby.kinematics().angular_velocity_rad_per_s.col(column), all.angular_velocity_rad_per_s.col(body));
      EXPECT_EQ(nearby.returned_mass()[place], 0.5 * body);
      loads.push_back(Drift::load(ranks.rank(), body, step));
    }
    MomentumSums gained = {ranks.rank(), -ranks.rank(), fixed_point::Sum{1} << 80};
    nearby.gather(loads, gained);
    nearby.finish();
    if (ranks.rank() != 0) continue;
    EXPECT_EQ(nearby.all_kinematics().step, step);
    EXPECT_EQ(nearby.all_kinematics().position_m, all.position_m);
    EXPECT_EQ(nearby.all_kinematics().orientation_wxyz, all.orientation_wxyz);
    EXPECT_EQ(nearby.all_kinematics().velocity_m_per_s, all.velocity_m_per_s);
    EXPECT_EQ(nearby.all_kinematics().angular_velocity_rad_per_s, all.angular_velocity_rad_per_s);
    const fixed_point::Sum n = ranks.size();
    EXPECT_TRUE(gained == (MomentumSums{n * (n - 1) / 2, -n * (n - 1) / 2, n << 80}));
    for (std::int32_t b = 0; b < Drift::bodies; ++b) {
      LoadSums sums{};
      for (const int rank : hears_of(step, b))
        for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += Drift::load(rank, b, step)[i];
      for (std::size_t i = 0; i < sums.size(); ++i)
        EXPECT_TRUE(nearby.total(static_cast<std::size_t>(b), i) == sums[i]) << "body " << b << ", component " << i;
    }
  }
}

class NearbyBodiesOn : public testing::TestWithParam<int> {};

// 70 ranks are three groups: what two of them need is relayed.
TEST_P(NearbyBodiesOn, AreToldOnceMoreWhenTheyLeaveAndTheirLoadsAddUpExactly) {
  SolverContext context;
  ThreadRanks ranks(GetParam(), context, follow_the_drift);
  follow_the_drift(ranks.leader());
}

INSTANTIATE_TEST_SUITE_P(Ranks, NearbyBodiesOn, testing::Values(1, 2, 5, 70));

TEST(NearbyBodies, AreThoseOfTheSetup) {
  SolverContext context;
  SelfCommunicator self{context};
  for (const std::size_t bodies : {std::size_t{0}, std::size_t{2}}) {
    const FluidSetup setup =
        box({8, 8, 8}, {periodic, periodic, periodic}, std::vector<Shape>(bodies, {ShapeKind::sphere, 1.0, 0.0}));
    const LatticeUnits units(setup);
    const Domain domain(setup, units);
    const BlockPartition partition(domain.cells(), 1);
    NearbyBodies nearby(setup, units, domain, partition, false, self);
    Kinematics kinematics;
    kinematics.resize(1);
    kinematics.position_m.setZero();
    EXPECT_THROW(nearby.scatter(kinematics, {}), SolverError);
  }
}

}  // namespace
}  // namespace copepod::fluid
