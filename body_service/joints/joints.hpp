#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "joints/joint_rows.hpp"
#include "model/body_block.hpp"
#include "model/body_model.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Forces of ideal joints, found from the accelerations that they have to prevent, and the correction of the drift
/// that is left by the integrator; docs/decisions/joints.md has the reasons.
///
/// Joints that share a body that moves belong to one island, whose equations are solved together in the joints' order:
/// no bit depends on the order of the bodies.
class Joints {
 public:
  /// @param model  must outlive this object
  /// @throws CaseError naming the joint if its bodies, anchors or axis are not valid
  Joints(const BodySetup& setup, const BodyModel& model);

  [[nodiscard]] bool empty() const { return islands_.empty(); }

  /// How driven joints move in the step ahead: on the parabola through the values at its start, middle and end.
  /// @param actuation  shape (actuators, 3); others than those of joints are not read
  void drive(const Eigen::MatrixXd& actuation, double step_s);

  /// Adds the forces of the joints' springs (B33), and then those that keep the joints, Jᵀλ, with λ from
  ///   (J M⁻¹ Jᵀ) λ = −c − J M⁻¹ F                                                               (B31)
  /// @param at              fraction of the step
  /// @param state, force_N, torque_N_m  column 0 is the block's first body
  void add_loads(const BodyBlock& block, const MotionState& state, double at, Eigen::Matrix3Xd& force_N,
                 Eigen::Matrix3Xd& torque_N_m);

  /// Moves the bodies of a block by M⁻¹ Jᵀ μ until C = 0, and changes their velocities alike until
  /// J (v, ω) + b = 0                                                                             (B32)
  /// Joints beyond a limit return to it, and no longer move outwards                               (B34)
  /// @param state  of all bodies
  /// @param at     fraction of the step
  /// @throws SolverError if the errors do not vanish
  void correct(const BodyBlock& block, double at, MotionState& state, std::int64_t step);

 private:
  struct Joint {
    std::array<int, 2> bodies{0, -1};  ///< A and B; −1: the world
    JointSpecification specification;
    int first_row = 0;
    int actuator = -1;  ///< that drives it; −1: none
    JointEquations equations;

    /// Those of the equations and, of a joint with limits, that of its stops.
    [[nodiscard]] int rows() const { return equations.rows() + (specification.has_limits() ? 1 : 0); }
  };
  struct Island {
    Eigen::Index block_key;  ///< a body of it that moves
    std::vector<Joint> joints;
    Eigen::Index rows = 0;
  };

  [[nodiscard]] std::span<const Island> islands_of(const BodyBlock& block) const;
  [[nodiscard]] JointMotion motion(const Joint& joint, double at) const;
  [[nodiscard]] JointSide side(int body, Eigen::Index first, const MotionState& state) const;
  [[nodiscard]] bool moves(int body) const;
  [[nodiscard]] Eigen::Vector3d per_mass(int body, const Eigen::Vector3d& force_N) const;
  [[nodiscard]] Eigen::Vector3d per_inertia(int body, const JointSide& side, const Eigen::Vector3d& torque_N_m) const;
  void list_rows(const Island& island, Eigen::Index first, double at, const MotionState& state);
  void add_springs(const Island& island, Eigen::Index first, Eigen::Matrix3Xd& force_N,
                   Eigen::Matrix3Xd& torque_N_m) const;
  void factorise(const Island& island);
  void solve(Eigen::Index rows);
  void correct(const Island& island, double at, MotionState& state, std::int64_t step);
  void stop(const Island& island, const MotionState& state);
  [[nodiscard]] bool release(const Island& island);
  [[nodiscard]] JointRow stop_row(const Joint& joint, int stop, const std::array<JointSide, 2>& sides) const;
  /// @throws SolverError if the rows have errors that Newton's method did not remove
  void require_closed(const Island& island, std::int64_t step) const;
  void correct_positions(const Island& island, MotionState& state) const;
  void correct_velocities(const Island& island, MotionState& state);

  const BodyModel& model_;
  std::vector<Island> islands_;  ///< by key
  Eigen::MatrixX3d nodes_;       ///< values of the actuators in the step; no rows: nothing has moved yet
  double step_s_ = 0.0;

  // Of the island in work.
  std::vector<std::array<JointSide, 2>> sides_;  ///< of each joint
  std::vector<int> stops_;                       ///< of each joint: −1 at its lowest, 1 at its highest, 0 at none
  std::vector<JointRow> rows_;
  std::vector<JointRow> response_;  ///< M⁻¹ Jᵀ
  Eigen::MatrixXd matrix_;          ///< J M⁻¹ Jᵀ with unit diagonal
  Eigen::VectorXd scale_;
  Eigen::VectorXd right_side_;
  Eigen::VectorXd multipliers_;
  Eigen::LLT<Eigen::MatrixXd> factors_;
};

}  // namespace copepod::body
