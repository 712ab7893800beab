#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"

namespace copepod::coupler {

/// Whether a component lacks actuators that a case requires, but takes world forces or torques in their place.
bool must_be_lowered(const std::set<std::string>& required, const std::set<std::string>& announced);

/// The setup with world forces, and world torques where they are needed, along x, y and z in place of its actuators.
BodySetup lowered(const BodySetup& setup);

/// Drives a body solver that lacks actuators which follow its bodies: the loads of the drive are computed here and
/// sent as world forces. Their directions are those at the start of a step, so the drive is of first
/// order in the step.
class LoweredBodies final : public BodySolver {
 public:
  /// @param solver  made of lowered(setup)
  LoweredBodies(std::unique_ptr<BodySolver> solver, const BodySetup& setup);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return solver_->driving_nodes(); }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override { solver_->save(path); }
  void restore(const std::string& path) override { solver_->restore(path); }
  SolverSummary summarise() override { return solver_->summarise(); }

 private:
  std::unique_ptr<BodySolver> solver_;
  std::vector<ActuatorSpecification> actuators_;
  std::vector<ActuatorSpecification> lowered_;
  Kinematics start_;  ///< of the next step
  Loads drive_;
  AppliedLoads applied_;
};

}  // namespace copepod::coupler
