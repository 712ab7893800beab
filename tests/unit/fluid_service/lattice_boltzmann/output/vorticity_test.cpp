#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "lattice_boltzmann/output/fields.hpp"

namespace copepod::fluid {
namespace {

constexpr double cell_m = 0.5;

/// 4 × 6 × 5 cells of half a metre and a step of one second, with walls along z.
FluidSetup channel() {
  FluidSetup setup;
  setup.domain_cells = {4, 6, 5};
  setup.cell_size_m = cell_m;
  setup.step_s = 1.0;
  setup.density_kg_per_m3 = 1000.0;
  for (int face : {0, 1, 2, 3}) setup.boundaries[static_cast<std::size_t>(face)].kind = BoundaryKind::periodic;
  return setup;
}

/// The block of a rank that holds everything, with the velocity of each cell's centre.
template <class Velocity>
FieldBlock flow(const Box& box, const Velocity& velocity) {
  FieldBlock block;
  block.box = box;
  for_each_cell(box, [&](const Cell& cell) {
    const Eigen::Vector3d u = velocity(Eigen::Vector3d((static_cast<double>(cell[0]) + 0.5) * cell_m,
                                                       (static_cast<double>(cell[1]) + 0.5) * cell_m,
                                                       (static_cast<double>(cell[2]) + 0.5) * cell_m));
    block.velocity_m_per_s.insert(block.velocity_m_per_s.end(), u.begin(), u.end());
    block.density_kg_per_m3.push_back(1000.0);
    block.body.push_back(0);
  });
  return block;
}

std::vector<double> vorticity(const FluidSetup& setup, const FieldBlock& block) {
  SolverContext context;
  SelfCommunicator self(context);
  return vorticity(setup, block, self);
}

Eigen::Vector3d at(const std::vector<double>& values, std::size_t cell) {
  return Eigen::Map<const Eigen::Vector3d>(&values[3 * cell]);
}

TEST(Vorticity, OfLinearShearIsItsRateUpToTheWalls) {
  FluidSetup setup = channel();
  setup.boundaries[5] = {BoundaryKind::velocity, {3.0 * 2.5, 0, 0}, 0};  // u_x = 3 z, the wall at z = 2.5 m
  const auto result = vorticity(
      setup, flow({{0, 0, 0}, {4, 6, 5}}, [](const Eigen::Vector3d& p) { return Eigen::Vector3d(3.0 * p.z(), 0, 0); }));
  for (std::size_t cell = 0; cell < 120; ++cell) EXPECT_TRUE(at(result, cell).isApprox(Eigen::Vector3d(0, 3.0, 0)));
}

TEST(Vorticity, OfARotationIsTwiceItsRateAndZeroInBodies) {
  const Eigen::Vector3d w(0.1, -0.2, 0.3);
  FluidSetup setup = channel();
  for (Boundary& boundary : setup.boundaries) boundary.kind = BoundaryKind::pressure;  // one-sided at all faces
  FieldBlock block = flow({{0, 0, 0}, {4, 6, 5}}, [&](const Eigen::Vector3d& p) { return w.cross(p).eval(); });
  block.body[70] = 1;
  const auto result = vorticity(setup, block);
  for (std::size_t cell = 0; cell < 120; ++cell) {
    const Eigen::Vector3d expected = cell == 70 ? Eigen::Vector3d::Zero() : Eigen::Vector3d(2.0 * w);
    EXPECT_TRUE(at(result, cell).isApprox(expected)) << cell;
  }
}

TEST(Vorticity, SeesThePeriodicNeighbourAndTheMirrorImage) {
  FluidSetup setup = channel();
  setup.boundaries[4].kind = setup.boundaries[5].kind = BoundaryKind::free_slip;
  // Two sheets of flow along y: at the periodic face normal to x, and at the mirror normal to z.
  const auto result =
      vorticity(setup, flow({{0, 0, 0}, {4, 6, 5}}, [](const Eigen::Vector3d& p) {
                  return Eigen::Vector3d(0, (p.x() < cell_m ? 1.0 : 0.0) + (p.z() < cell_m ? 1.0 : 0.0), 0);
                }));
  const auto cell = [](std::size_t x, std::size_t y, std::size_t z) { return (x * 6 + y) * 5 + z; };
  EXPECT_EQ(at(result, cell(0, 0, 2)).z(), 0.0) << "symmetric about the sheet";
  EXPECT_EQ(at(result, cell(1, 0, 2)).z(), -1.0);
  EXPECT_EQ(at(result, cell(3, 0, 2)).z(), 1.0);
  EXPECT_EQ(at(result, cell(2, 0, 2)).z(), 0.0);
  EXPECT_EQ(at(result, cell(2, 0, 0)).x(), 1.0) << "the mirror image of the first row is that row";
  EXPECT_EQ(at(result, cell(2, 0, 1)).x(), 1.0);
  EXPECT_EQ(at(result, cell(2, 0, 4)).x(), 0.0);
}

}  // namespace
}  // namespace copepod::fluid
