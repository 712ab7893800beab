#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/solver.hpp"
#include "contract/solver_context.hpp"
#include "engine/engine_world.hpp"
#include "forces/forces.hpp"
#include "model/body_block.hpp"
#include "model/body_model.hpp"

namespace copepod::body {

/// Spheres and capsules moved by the library of a rigid-body engine, in double precision; forces are those of
/// RigidBodySolver, contacts and joints those of the engine.
///
/// First order in the step: against the exact motion, positions are off by half a step's way, h v/2, plus
/// what the integrator's frequency error adds up to, (ω h)²/24 of the phase; docs/decisions/engines.md
/// has the derivation. Contacts across periodic faces are not detected.
class EngineBodySolver final : public BodySolver {
 public:
  /// @param engine   its name; states of other engines do not fit
  /// @param context  to report progress to while a state is saved or restored; null: none. Outlives
  /// the solver
  /// @throws CaseError if the setup is not valid
  EngineBodySolver(std::string_view engine, const MakeEngineWorld& make_world, const BodySetup& setup,
                   SolverContext* context = nullptr);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return world_->driving_nodes(); }
  void kinematics(Kinematics& kinematics) override { kinematics = state_; }
  void step(const AppliedLoads& applied, Kinematics& next) override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  void add_forces(const AppliedLoads& applied);

  SolverContext* context_;
  std::uint64_t layout_digest_;  ///< of the setup and the engine
  BodyModel model_;
  Weight weight_;
  Actuators drive_;
  Bends bends_;
  Springs springs_;
  BodyBlock all_;  ///< bodies
  CentreLines lines_;
  std::int64_t substeps_;
  std::unique_ptr<EngineWorld> world_;
  Kinematics state_;
  Loads loads_;  ///< of the substep
  double integration_s_ = 0.0;
};

}  // namespace copepod::body
