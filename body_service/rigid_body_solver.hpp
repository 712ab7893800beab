#pragma once

#include <optional>
#include <vector>

#include "contact/contacts.hpp"
#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/solver.hpp"
#include "contract/solver_context.hpp"
#include "integration/integration.hpp"
#include "model/exits.hpp"
#include "model/motion_state.hpp"
#include "threads/thread_team.hpp"

namespace copepod::body {

/// What RigidBodySolver can do, for the component's Hello.
Capabilities rigid_body_capabilities();

/// Rigid spheres and capsules with springs, actuators, gravity, constraints and contacts; the theory is in
/// docs/theory_bodies.md.
class RigidBodySolver final : public BodySolver {
 public:
  /// @param context  to report progress to while a state is saved or restored; null: none. Outlives
  /// the solver
  /// @throws CaseError if the setup is not valid, SolverError if bodies overlap at the start
  explicit RigidBodySolver(const BodySetup& setup, SolverContext* context = nullptr);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return nodes_; }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  /// @param next  receives the motion of the bodies; null: nothing does
  void integrate(const AppliedLoads& applied, double step_s, Kinematics* next);
  /// In substeps, with the impulses of the contacts between them, and half of one at both ends.
  void integrate_with_contacts(const AppliedLoads& applied);
  void push_contacts(const Contacts::Interval& interval);
  /// Values of the drive at the nodes of a part of the step.
  /// @param from, to  fractions of the step
  void interpolate_drive(const AppliedLoads& applied, double from, double to);
  /// Calls `work_on(block, work of the thread)` for all blocks, in several threads.
  template <class WorkOn>
  void for_each_block(const WorkOn& work_on) {
    const std::vector<BodyBlock>& blocks = equations_.blocks();
    team_.share(static_cast<std::int64_t>(blocks.size()),
                [&](std::int64_t block, int thread) { work_on(blocks[block], work_[thread]); });
  }
  /// @param work  its state is written
  void write(const BodyBlock& block, IntegratorWork& work, Kinematics& kinematics) const;
  void correct_joints(double at);
  [[nodiscard]] std::vector<std::uint64_t> memory() const {
    return contacts_ ? contacts_->memory() : std::vector<std::uint64_t>{};
  }

  SolverContext* context_;
  std::uint64_t layout_digest_;  ///< of the setup: a saved state fits these bodies only
  EquationsOfMotion equations_;
  Integrator integrator_;
  std::vector<IntegratorWork> work_;  ///< of each thread
  ThreadTeam team_;
  double step_s_;
  Eigen::Index actuators_;
  std::vector<double> nodes_;  ///< samples of the drive, as fractions of a step
  Exits exits_;
  NearPairs near_pairs_;
  OverlapCheck overlap_check_;
  std::optional<Contacts> contacts_;  ///< none: bodies that meet end the run
  std::int64_t substeps_ = 1;
  AppliedLoads applied_in_part_;  ///< the same loads, with the drive of a part of the step
  MotionState state_;
  std::int64_t step_ = 0;
  double integration_s_ = 0.0;
  double contact_s_ = 0.0;
};

}  // namespace copepod::body
