#pragma once

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/solver.hpp"
#include "driving/driving_protocol.hpp"
#include "geometry/shapes/overlaps.hpp"

namespace copepod::coupler {

/// Takes prescribed bodies out of a setup; nothing in it may act on them.
/// @param prescribed  ascending
void take_out(const std::vector<PrescribedBody>& prescribed, BodySetup& setup);

/// All bodies of a case, of which the body component has those that are not prescribed. The position of a prescribed
/// body follows from the number of the step alone, unless it was steered, with w the signal:
///   x(n) = x(0) + V Δt ∫₀ⁿ w dt,   q(n) = exp(Ω Δt ∫₀ⁿ w dt / 2) ⊗ q(0)                              (C18)
/// Prescribed bodies do not collide: a run ends where one overlaps with another body.
class PrescribedBodies final : public BodySolver {
 public:
  /// @param others  has the bodies that are left by `take_out`
  /// @param bodies  all of them
  /// @param driving  has the signals; outlives this object
  /// @param setup   what `take_out` left; step and periodic lengths count
  PrescribedBodies(std::unique_ptr<BodySolver> others, const std::vector<BodySpecification>& bodies,
                   const std::vector<PrescribedBody>& prescribed, DrivingProtocol& driving, const BodySetup& setup);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return others_->driving_nodes(); }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override { others_->save(path); }
  void restore(const std::string& path) override { others_->restore(path); }
  SolverSummary summarise() override { return others_->summarise(); }

 private:
  /// All bodies from those of the component.
  void complete(Kinematics& kinematics);
  void check_overlaps(const Kinematics& kinematics) const;

  std::unique_ptr<BodySolver> others_;
  std::vector<BodySpecification> bodies_;
  std::vector<Eigen::Index> free_;        ///< numbers of the others' bodies
  std::vector<Eigen::Index> prescribed_;  ///< of the prescribed ones
  DrivingProtocol& driving_;
  double step_s_;
  Overlaps overlaps_;
  Kinematics others_kinematics_;
  AppliedLoads others_applied_;
};

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
