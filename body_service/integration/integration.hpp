#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "forces/forces.hpp"
#include "joints/joints.hpp"
#include "model/body_block.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// The Newton-Euler equations of all bodies, evaluated block by block:
///   dx/dt = v,   m dv/dt = F,   dq/dt = 1/2 (0, ω) ⊗ q,   dL/dt = τ                        (B9), (B10)
/// with F and τ the sums of drive, hydrodynamic load and force elements, less the constraint forces.
class EquationsOfMotion {
 public:
  /// Of the block in work; each thread has its own.
  struct Work {
    explicit Work(Eigen::Index bodies);

    BlockVectors hydrodynamic_force_N;
    BlockVectors hydrodynamic_torque_N_m;
    BlockVectors angular_velocity_rad_per_s;
    CentreLines lines;
    Joints::Work joints;
  };

  /// @param preferred_block_bodies  see independent_blocks
  EquationsOfMotion(const BodySetup& setup, Eigen::Index preferred_block_bodies);

  [[nodiscard]] const BodyModel& model() const { return model_; }
  [[nodiscard]] const std::vector<BodyBlock>& blocks() const { return blocks_; }

  [[nodiscard]] Joints& joints() { return joints_; }
  [[nodiscard]] const Joints& joints() const { return joints_; }

  /// Bodies of the longest block: what a work array must hold.
  [[nodiscard]] Eigen::Index longest_block() const;

  /// Prepares for evaluations of a block in one step.
  void begin(const BodyBlock& block, const AppliedLoads& applied, Work& work) const;

  /// Rate of change of a block's state, after begin().
  /// @param node   which sample of the drive applies
  /// @param state  of the block's bodies, column 0 is body block.first
  /// @param rate   overwritten, same columns
  /// @throws SolverError if a force element does
  void evaluate(const BodyBlock& block, const AppliedLoads& applied, Eigen::Index node, const BlockState& state,
                BlockState& rate, Work& work) const;

 private:
  void constrain(const BodyBlock& block, BlockVectors& force_N, BlockVectors& torque_N_m) const;

  BodyModel model_;
  Actuators drive_;
  std::vector<std::unique_ptr<const ForceElement>> elements_;
  Joints joints_;
  std::vector<BodyBlock> blocks_;
};

/// Of the block in work; each thread has its own.
struct IntegratorWork {
  /// @param bodies  of the longest block
  explicit IntegratorWork(Eigen::Index bodies) : equations(bodies) {
    for (BlockState* part : {&state, &stage, &rate, &rate_sum}) part->resize(bodies);
  }

  BlockState state;  ///< of the bodies, column 0 is body block.first
  BlockState stage;
  BlockState rate;
  BlockState rate_sum;
  EquationsOfMotion::Work equations;
};

/// See BodySolver::driving_nodes.
/// @throws CaseError for an unknown integrator
std::vector<double> driving_nodes(Integrator kind);

/// Advances the bodies of one block by a step, or by a part of one.
/// @param applied  with the drive at the driving nodes of these `step_s`
/// @param work     its state is advanced
/// @throws SolverError if a force is not defined in a state on the way
void advance(Integrator kind, const EquationsOfMotion& equations, const BodyBlock& block, const AppliedLoads& applied,
             double step_s, IntegratorWork& work);

}  // namespace copepod::body
