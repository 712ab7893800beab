#include <gtest/gtest.h>

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

std::vector<Loads> loads_along(const Paths& paths, bool symmetric) {
  FluidSetup setup = lattice_unit_setup({40, 20, 24}, 1.0 / 6.0, BoundaryKind::no_slip);
  setup.symmetry_planes[0] = symmetric;
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

// A sphere on the plane and a pair beside it that approaches it, moving by more than a cell, so cells are
// covered and uncovered. Computed in half, the pair is one sphere. Mirrors on cell faces are exact and loads
// are sums of integers, so only the conversion of torques rounds: 1e-12 of a force of order 1e-2.
TEST(MirrorImages, HalfOfAPairBesideThePlaneFeelsWhatItFeelsInTheWholeDomain) {
  const Eigen::Vector3d along(0.0, 0.002, 0.01);
  const Eigen::Vector3d towards(0.015, -0.004, 0.008);
  const Eigen::Vector3d image(-towards[0], towards[1], towards[2]);
  const auto whole =
      loads_along({{{20.0, 10.0, 8.0}, {11.3, 9.6, 12.2}, {28.7, 9.6, 12.2}}, {along, towards, image}}, false);
  const auto half = loads_along({{{20.0, 10.0, 8.0}, {11.3, 9.6, 12.2}}, {along, towards}}, true);
  double largest = 0.0;
  for (std::size_t step = 0; step < half.size(); ++step) {
    EXPECT_LT((half[step].force_N - whole[step].force_N.leftCols(2)).cwiseAbs().maxCoeff(), 1e-12) << step;
    EXPECT_LT((half[step].torque_N_m - whole[step].torque_N_m.leftCols(2)).cwiseAbs().maxCoeff(), 1e-11) << step;
    largest = std::max(largest, half[step].force_N.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(largest, 1e-2);
}

TEST(MirrorImages, ABodyThatReachesThePlaneIsToldOfItsImage) {
  EXPECT_THROW(loads_along({{{16.0, 10.0, 12.0}}, {{0.02, 0.0, 0.0}}}, true), SolverError);
}

}  // namespace
}  // namespace copepod::fluid::validation
