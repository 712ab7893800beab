#pragma once

#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// A fluid that is not there: zero loads on every body, no lattice, no state [physics.md §6].
class Vacuum final : public FluidSolver {
 public:
  Vacuum(const FluidSetup& setup, const Communicator& communicator);

  /// @throws SolverError if the number of bodies is not that of the setup
  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override {}
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  Eigen::Index bodies_;
  int rank_;
  int ranks_;
};

}  // namespace copepod::fluid
