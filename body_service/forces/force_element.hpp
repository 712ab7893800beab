#pragma once

#include <Eigen/Core>

#include "forces/centre_lines.hpp"
#include "model/body_block.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// The bodies of one block at one stage of the integrator: all that a force may depend on.
struct Stage {
  const BodyBlock& block;
  const BlockState& state;                         ///< column 0 is body block.first
  const BlockVectors& angular_velocity_rad_per_s;  ///< same columns, world frame
  const CentreLines& lines;                        ///< of the block, measured
  Eigen::Ref<const Eigen::VectorXd> actuation;     ///< value of every actuator of the case [N] or [N m]
};

/// One kind of force between or on bodies. The equations of motion hold a list of them; the order of the list
/// is the order of the sums.
class ForceElement {
 public:
  ForceElement() = default;
  ForceElement(const ForceElement&) = delete;
  ForceElement& operator=(const ForceElement&) = delete;
  virtual ~ForceElement() = default;

  /// Adds the forces and the torques about the centres of mass on the bodies of a block, world frame.
  /// @param force_N, torque_N_m  sums to add to, shape (3, ≥ bodies), same columns as the stage
  /// @throws SolverError if a force is not defined in this state
  virtual void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const = 0;
};

}  // namespace copepod::body
