#include "lattice_boltzmann/lattice_boltzmann.hpp"

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::fluid {
namespace {

constexpr std::int64_t mebibyte = 1 << 20;

FluidSetup channel() {
  FluidSetup setup;
  setup.cell_size_m = setup.step_s = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = {100, 100, 200};
  return setup;
}

TEST(EstimateLatticeBoltzmann, CountsPopulationsGhostsAndPadding) {
  const std::int64_t bytes = estimate_lattice_boltzmann_bytes(channel(), 1);
  const std::int64_t populations = std::int64_t{19} * 8 * 100 * 100 * 200;
  EXPECT_GT(bytes, populations + 4 * 100 * 100 * 200);
  EXPECT_LT(static_cast<double>(bytes), 1.2 * static_cast<double>(populations));
}

TEST(EstimateLatticeBoltzmann, FallsWithRanksPrecisionAndSymmetry) {
  const auto whole = static_cast<double>(estimate_lattice_boltzmann_bytes(channel(), 1));
  EXPECT_NEAR(static_cast<double>(estimate_lattice_boltzmann_bytes(channel(), 4)) / whole, 0.26, 0.02);
  FluidSetup changed = channel();
  changed.precision = Precision::single_precision;
  EXPECT_NEAR(static_cast<double>(estimate_lattice_boltzmann_bytes(changed, 1)) / whole, 0.52, 0.02);
  changed = channel();
  changed.symmetry_planes = {true, true, false};
  EXPECT_NEAR(static_cast<double>(estimate_lattice_boltzmann_bytes(changed, 1)) / whole, 0.26, 0.02);
}

TEST(EstimateLatticeBoltzmann, CountsCopiesOfFieldsThatAreWritten) {
  FluidSetup setup = channel();
  const std::int64_t without = estimate_lattice_boltzmann_bytes(setup, 1);
  setup.fields.every_steps = 10;
  const std::int64_t snapshots = estimate_lattice_boltzmann_bytes(setup, 1);
  EXPECT_EQ(snapshots - without, (36 + 24) * std::int64_t{2'000'000} + 4 * mebibyte);
  setup.fields.quantities = {FieldQuantity::velocity, FieldQuantity::vorticity};
  EXPECT_EQ(estimate_lattice_boltzmann_bytes(setup, 1) - snapshots, 24 * 2'000'000);
  setup.fields.quantities.clear();
  setup.fields.mean_stop = 100;
  EXPECT_EQ(estimate_lattice_boltzmann_bytes(setup, 1) - snapshots, 36 * 2'000'000);
}

TEST(EstimateLatticeBoltzmann, RefusesRanksThatCannotCutTheDomain) {
  try {
    estimate_lattice_boltzmann_bytes(channel(), 211);
    FAIL() << "211 is prime and longer than every axis";
  } catch (const CaseError& error) {
    EXPECT_NE(std::string(error.what()).find("ranks 211"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("Use 210 ranks"), std::string::npos);
  }
}

/// A sphere in a flow past something solid on the wall below it.
class Obstacles : public testing::Test {
 protected:
  Obstacles() {
    setup_.domain_cells = {20, 16, 16};
    for (std::size_t face : {0, 1, 2, 3}) setup_.boundaries[face].kind = BoundaryKind::periodic;
    setup_.boundaries[4].kind = setup_.boundaries[5].kind = BoundaryKind::no_slip;
    setup_.body_force_N_per_m3 = {1e-5, 0.0, 0.0};
    setup_.bodies = {{.radius_m = 2.5}};
    setup_.film_thickness_m = 1.5;
    setup_.obstacles = {{"block", {.kind = ShapeKind::box, .extents_m = {5.0, 7.3, 9.0}}, {9.2, 8.1, 0.3}},
                        {"pearl", {.radius_m = 3.0}, {12.6, 8.0, 2.0}}};
    kinematics_.resize(1);
    kinematics_.position_m.col(0) << 4.0, 8.4, 9.7;
    kinematics_.orientation_wxyz.col(0) << 1, 0, 0, 0;
    kinematics_.velocity_m_per_s.setZero();
    kinematics_.angular_velocity_rad_per_s.setZero();
  }

  std::uint64_t digest_after_20_steps(const FluidSetup& setup, Kinematics kinematics) {
    const auto solver = make_lattice_boltzmann(setup, alone_);
    for (int step = 0; step < 20; ++step) {
      kinematics.position_m += kinematics.velocity_m_per_s;
      solver->exchange(kinematics, loads_);
      solver->advance();
    }
    return solver->summarise().digest;
  }

  SolverContext context_;
  SelfCommunicator alone_{context_};
  FluidSetup setup_ = channel();
  Kinematics kinematics_;
  Loads loads_;
};

TEST_F(Obstacles, AreBodiesThatNeverMoveAndMayReachBeyondFaces) {
  const std::uint64_t with_obstacles = digest_after_20_steps(setup_, kinematics_);
  const Loads on_sphere = loads_;
  ASSERT_EQ(on_sphere.bodies(), 1);
  FluidSetup bodies = setup_;
  Kinematics all = kinematics_;
  all.resize(3);
  all.velocity_m_per_s.setZero();
  all.angular_velocity_rad_per_s.setZero();
  all.position_m.col(0) = kinematics_.position_m.col(0);
  all.orientation_wxyz.colwise() = Eigen::Vector4d(1, 0, 0, 0);
  for (Eigen::Index i = 0; const ObstacleSpecification& obstacle : setup_.obstacles) {
    bodies.bodies.push_back(obstacle.shape);
    all.position_m.col(++i) = obstacle.position_m;
  }
  bodies.obstacles.clear();
  EXPECT_EQ(with_obstacles, digest_after_20_steps(bodies, all));
  EXPECT_EQ(on_sphere.force_N.col(0), loads_.force_N.col(0));
  EXPECT_GT(on_sphere.force_N(0, 0), 0.0);
  setup_.obstacles.pop_back();
  EXPECT_NE(with_obstacles, digest_after_20_steps(setup_, kinematics_));
}

// Links of the body are computed by lanes, and one by one as those of a compound. The obstacle is aslant: links enter
// it further from its centre than from that of its image.
TEST_F(Obstacles, AndBodiesThatAreEllipsoidsAreLikeCompoundsOfOne) {
  setup_.moving_boundary = MovingBoundary::parabolic;
  setup_.bodies = {{.kind = ShapeKind::ellipsoid, .radius_m = 2.1, .extents_m = {1.5, 2.2, 2.9}}};
  const Shape needle{.kind = ShapeKind::ellipsoid, .radius_m = 3.0, .extents_m = {1.8, 1.8, 13.0}};
  setup_.obstacles = {{"needle", needle, {14.2, 8.1, 8.3}, {0.8, 0.6, 0.0, 0.0}}};
  kinematics_.position_m(0, 0) = 7.2;
  kinematics_.orientation_wxyz.col(0) << 0.8, 0.36, 0.48, 0.0;
  kinematics_.angular_velocity_rad_per_s.col(0) << 0.002, 0.001, -0.003;
  const std::uint64_t found = digest_after_20_steps(setup_, kinematics_);
  for (Shape* const shape : {&setup_.bodies[0], &setup_.obstacles[0].shape}) {
    *shape = {.kind = ShapeKind::compound, .radius_m = 3.0, .parts = {{.shape = Shape(*shape)}}};
    EXPECT_EQ(found, digest_after_20_steps(setup_, kinematics_));
  }
}

// Loads on an obstacle that reaches through periodic faces are summed link by link. Otherwise its links are computed by
// lanes, with wall distances that stay until the sphere, which passes half a cell away, covers or uncovers cells there.
TEST_F(Obstacles, TreatTheFluidAlikeWhetherTheirLoadsAreWantedOrNot) {
  setup_.moving_boundary = MovingBoundary::parabolic;
  const Shape needle{.kind = ShapeKind::ellipsoid, .radius_m = 3.0, .extents_m = {1.8, 1.8, 13.0}};
  setup_.obstacles = {{"needle", needle, {14.2, 8.1, 8.3}, {0.8, 0.6, 0.0, 0.0}}};
  kinematics_.position_m.col(0) << 9.4, 8.4, 6.7;
  kinematics_.velocity_m_per_s.col(0) << 0.0, 0.03, 0.08;
  const std::uint64_t found = digest_after_20_steps(setup_, kinematics_);
  setup_.obstacles[0].loads = true;
  EXPECT_EQ(found, digest_after_20_steps(setup_, kinematics_));
  EXPECT_EQ(loads_.bodies(), 2);
}

TEST_F(Obstacles, EndTheRunOfABodyThatMeetsThem) {
  const auto solver = make_lattice_boltzmann(setup_, alone_);
  try {
    for (; kinematics_.position_m(2, 0) > 3.0; kinematics_.position_m(2, 0) -= 0.05) {
      kinematics_.position_m(0, 0) += 0.02;
      solver->exchange(kinematics_, loads_);
      solver->advance();
    }
    FAIL() << "it went through";
  } catch (const SolverError& error) {
    EXPECT_NE(std::string(error.what()).find("body 0 met obstacle 'block'"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace copepod::fluid
