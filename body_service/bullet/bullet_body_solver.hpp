#pragma once

#include <functional>

#include "bullet/bullet_world.hpp"
#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"
#include "contract/capabilities.hpp"
#include "contract/solver_context.hpp"
#include "forces/actuators.hpp"
#include "forces/bends.hpp"
#include "forces/weight.hpp"
#include "model/body_block.hpp"
#include "model/body_model.hpp"

namespace copepod::body {

/// What BulletBodySolver can do, for the component's Hello.
Capabilities bullet_capabilities();

/// Spheres and capsules moved by the Bullet library, in double precision: springs and joints are rows of its
/// constraint solver. Bodies that touch are kept apart, without friction or rebound, where RigidBodySolver
/// ends the run.
///
/// First order in the step: against the exact motion, positions are off by half a step's way, h v/2, plus
/// what the integrator's frequency error adds up to, (ω h)²/24 of the phase; docs/decisions/bullet_bodies.md
/// has the derivation. Contacts across periodic faces are not detected.
class BulletBodySolver final : public BodySolver {
 public:
  /// @param context  to report progress to while a state is saved or restored; null: none. Outlives
  /// the solver
  /// @throws CaseError if the setup is not valid
  explicit BulletBodySolver(const BodySetup& setup, SolverContext* context = nullptr);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }
  void kinematics(Kinematics& kinematics) override;
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  [[nodiscard]] std::function<void()> report_progress() const;

  SolverContext* context_;
  std::uint64_t layout_digest_;  ///< of the setup, and of Bullet: states of the other solver do not fit
  BodyModel model_;
  Weight weight_;
  Actuators drive_;
  Bends bends_;
  BodyBlock all_;  ///< bodies
  BulletWorld world_;
  BulletState state_;
  Loads loads_;  ///< of the step, springs excepted
  std::int64_t step_ = 0;
  double integration_s_ = 0.0;
};

}  // namespace copepod::body
