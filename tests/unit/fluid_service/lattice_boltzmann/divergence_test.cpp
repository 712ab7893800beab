#include <filesystem>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "temporary_folder.hpp"

namespace copepod::fluid {
namespace {

constexpr Cell cells = {5, 10, 20};
constexpr Cell last = {4, 9, 19};
constexpr int rows = 50;

FluidSetup periodic_box() {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = cells;
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::periodic;
  return setup;
}

class Divergence : public testing::Test {
 protected:
  void step() {
    kinematics_.step = solver_.step();
    solver_.exchange(kinematics_, loads_);
    solver_.advance();
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step();
  }
  /// Fluid at rest but for one cell of absurd density, in the last row.
  void spoil_one_cell() {
    solver_.initialise([](const Cell& cell) { return LocalFlow{cell == last ? 1e6 : 0.0}; });
  }

  SolverContext context_;
  SelfCommunicator self_{context_};
  LatticeBoltzmann<double> solver_{periodic_box(), self_};
  Kinematics kinematics_;
  Loads loads_;
};

TEST_F(Divergence, IsSeenBySteppingOnInADomainOfFewRows) {
  run(rows);
  spoil_one_cell();
  EXPECT_THROW(run(rows), SolverError);
}

TEST_F(Divergence, EntersNoFieldsNoSummaryAndNoCheckpoint) {
  const TemporaryFolder folder;
  const std::string checkpoint = folder.path("fluid.h5");
  run(rows);
  solver_.save(checkpoint);
  std::filesystem::remove(checkpoint);
  spoil_one_cell();
  EXPECT_THROW(static_cast<void>(solver_.fields()), SolverError);
  EXPECT_THROW(solver_.summarise(), SolverError);
  EXPECT_THROW(solver_.save(checkpoint), SolverError);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

}  // namespace
}  // namespace copepod::fluid
