#pragma once

#include <string>

#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// A fluid whose loads follow from the kinematics of the step alone: it has nothing to advance, and its checkpoint
/// holds no state. Rank 0 computes, the others only follow.
class StatelessFluid : public FluidSolver {
 public:
  void exchange(const Kinematics& kinematics, Loads& loads) final;
  void advance() final {}

  /// Rank 0 writes a checkpoint that holds the name of the solver and nothing else.
  /// @throws StorageError if it cannot be written
  void save(const std::string& path) final;
  /// @throws StorageError if it is missing, damaged or of another solver
  void restore(const std::string& path) final;
  SolverSummary summarise() override;

 protected:
  /// @param name  of the solver, as in a case file
  StatelessFluid(std::string name, const FluidSetup& setup, const Communicator& communicator);

 private:
  /// @param loads  of this step, zero on every body
  virtual void add_loads(const Kinematics& kinematics, Loads& loads) = 0;

  std::string name_;
  Eigen::Index bodies_;
  int rank_;
  int ranks_;
};

/// A fluid that is not there: zero loads on every body, no lattice [physics.md §6].
class Vacuum final : public StatelessFluid {
 public:
  Vacuum(const FluidSetup& setup, const Communicator& communicator) : StatelessFluid("vacuum", setup, communicator) {}

 private:
  void add_loads(const Kinematics&, Loads&) override {}
};

}  // namespace copepod::fluid
