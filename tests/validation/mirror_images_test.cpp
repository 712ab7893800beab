#include <gtest/gtest.h>

#include "contract/words.hpp"
#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

/// Spheres that move on given paths: (x, y, z) at step 0 and their constant velocities, which must be small.
struct Paths {
  std::vector<Eigen::Vector3d> start;
  std::vector<Eigen::Vector3d> velocity;

  [[nodiscard]] Kinematics at(std::int64_t step) const {
    std::vector<Eigen::Vector3d> positions;
    for (std::size_t b = 0; b < start.size(); ++b)
      positions.emplace_back(start[b] + static_cast<double>(step) * velocity[b]);
    Kinematics kinematics = resting(positions);
    for (std::size_t b = 0; b < velocity.size(); ++b)
      kinematics.velocity_m_per_s.col(static_cast<Eigen::Index>(b)) = velocity[b];
    return kinematics;
  }
};

std::vector<Loads> loads_along(const Paths& paths, bool symmetric, MovingBoundary moving_boundary, Refill refill) {
  FluidSetup setup = lattice_unit_setup({40, 20, 24}, 1.0 / 6.0, BoundaryKind::no_slip);
  setup.symmetry_planes[0] = symmetric;
  setup.moving_boundary = moving_boundary;
  setup.refill = refill;
  setup.bodies.assign(paths.start.size(), {ShapeKind::sphere, 3.2, 0.0});
  FlowCase flow(setup, paths.at(0));
  std::vector<Loads> loads;
  for (int step = 0; step < 80; ++step) {
    flow.kinematics() = paths.at(step);
    flow.run(1);
    loads.push_back(flow.loads());
  }
  return loads;
}

class MirrorImages : public testing::TestWithParam<std::pair<MovingBoundary, Refill>> {};

// A sphere on the plane, a pair beside it that approaches it, moving by more than a cell, so cells are covered
// and uncovered, and a pair whose surfaces come within a tenth of a cell of the plane: links lead to the image.
// Computed in half, each pair is one sphere. Mirrors on cell faces are exact and loads are sums of integers, so
// only the conversion of torques and, with refill formulas other than the equilibrium, the order of sums
// rounds: 1e-12 of a force of order 1e-2.
TEST_P(MirrorImages, HalfOfAPairBesideThePlaneFeelsWhatItFeelsInTheWholeDomain) {
  const auto [moving_boundary, refill] = GetParam();
  const Eigen::Vector3d along(0.0, 0.002, 0.01);
  const Eigen::Vector3d towards(0.015, -0.004, 0.008);
  const Eigen::Vector3d closing(0.0075, 0.005, 0.0);
  const auto image = [](const Eigen::Vector3d& v) { return Eigen::Vector3d(-v[0], v[1], v[2]); };
  const auto half = loads_along({{{20.0, 10.0, 5.0}, {11.3, 9.6, 12.2}, {16.1, 9.7, 18.3}}, {along, towards, closing}},
                                true, moving_boundary, refill);
  const auto whole =
      loads_along({{{20.0, 10.0, 5.0}, {11.3, 9.6, 12.2}, {16.1, 9.7, 18.3}, {28.7, 9.6, 12.2}, {23.9, 9.7, 18.3}},
                   {along, towards, closing, image(towards), image(closing)}},
                  false, moving_boundary, refill);
  double largest = 0.0;
  for (std::size_t step = 0; step < half.size(); ++step) {
    EXPECT_LT((half[step].force_N - whole[step].force_N.leftCols(3)).cwiseAbs().maxCoeff(), 1e-12) << step;
    EXPECT_LT((half[step].torque_N_m - whole[step].torque_N_m.leftCols(3)).cwiseAbs().maxCoeff(), 1e-11) << step;
    largest = std::max(largest, half[step].force_N.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, 1e-2);
}

INSTANTIATE_TEST_SUITE_P(Methods, MirrorImages,
                         testing::Values(std::pair(MovingBoundary::bounce_back, Refill::equilibrium),
                                         std::pair(MovingBoundary::interpolated, Refill::grad),
                                         std::pair(MovingBoundary::parabolic, Refill::nonequilibrium)),
                         [](const auto& instance) {
                           std::string name = name_of(moving_boundary_names, instance.param.first);
                           std::erase(name, '_');
                           return name;
                         });

TEST(MirrorImage, ABodyThatReachesThePlaneIsToldOfItsImage) {
  EXPECT_THROW(
      loads_along({{{16.0, 10.0, 12.0}}, {{0.02, 0.0, 0.0}}}, true, MovingBoundary::bounce_back, Refill::equilibrium),
      SolverError);
}

}  // namespace
}  // namespace copepod::fluid::validation
