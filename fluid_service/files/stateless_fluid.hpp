#pragma once

#include <fstream>
#include <iterator>
#include <string>
#include <utility>

#include "contract/errors.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "ranks/communicator.hpp"
#include "system/durable_file.hpp"

namespace copepod::fluid {

/// A fluid whose loads follow from the kinematics of the step alone: it has nothing to advance, and its checkpoint
/// holds no state. Rank 0 computes, the others only follow.
class StatelessFluid : public FluidSolver {
 public:
  void exchange(const Kinematics& kinematics, Loads& loads) final {
    if (rank_ != 0) return;
    if (kinematics.bodies() != bodies_)
      throw SolverError("kinematics of " + std::to_string(kinematics.bodies()) + " bodies (the setup has " +
                            std::to_string(bodies_) + "). Send every body in the order of the setup.",
                        rank_, kinematics.step);
    loads.step = kinematics.step;
    loads.force_N.setZero(3, bodies_);
    loads.torque_N_m.setZero(3, bodies_);
    add_loads(kinematics, loads);
  }
  void advance() final {}

  /// Rank 0 writes a checkpoint that holds the name of the solver and nothing else.
  /// @throws StorageError if it cannot be written
  void save(const std::string& path) final {
    if (rank_ == 0) write_durably(path, checkpoint_text());
  }
  /// @throws StorageError if it is missing, damaged or of another solver
  void restore(const std::string& path) final {
    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (text != checkpoint_text())
      throw StorageError("checkpoint " + path + " is not one of a " + name_ +
                         " fluid (missing, damaged or of another solver). Use an earlier checkpoint.");
  }
  SolverSummary summarise() override {
    SolverSummary summary;
    summary.ranks = ranks_;
    return summary;
  }

 protected:
  /// @param name  of the solver, as in a case file
  StatelessFluid(std::string name, const FluidSetup& setup, const Communicator& communicator)
      : name_(std::move(name)), bodies_(setup.bodies.size()), rank_(communicator.rank()), ranks_(communicator.size()) {}

 private:
  [[nodiscard]] std::string checkpoint_text() const { return "copepod " + name_ + " checkpoint 1\n"; }
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
