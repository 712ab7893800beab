#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <utility>
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
  /// Of the island in work; each thread has its own.
  struct Work {
    std::vector<std::array<JointSide, 2>> sides;  ///< of each joint
    std::vector<int> stops;                       ///< of each joint: −1 at its lowest, 1 at its highest, 0 at none
    std::vector<int> held;  ///< of each joint of the block: the stop that holds it through the step; empty: no step
    std::vector<JointRow> rows;
    std::vector<JointRow> response;  ///< M⁻¹ Jᵀ
    Eigen::MatrixXd matrix;          ///< J M⁻¹ Jᵀ with unit diagonal
    Eigen::VectorXd scale;
    Eigen::VectorXd right_side;
    Eigen::VectorXd multipliers;
    Eigen::LLT<Eigen::MatrixXd> factors;
  };

  /// @param model  must outlive this object
  /// @throws CaseError naming the joint if its bodies, anchors or axis are not valid
  Joints(const BodySetup& setup, const BodyModel& model);

  [[nodiscard]] bool empty() const { return islands_.empty(); }

  /// How long the step ahead is, and how driven joints move in it: on the parabola through the values at its start,
  /// middle and end.
  /// @param actuation  shape (actuators, 3); others than those of joints are not read
  void drive(const Eigen::MatrixXd& actuation, double step_s);

  /// Adds the forces of the joints' springs (B33), and then those that keep the joints, Jᵀλ, with λ from
  ///   (J M⁻¹ Jᵀ) λ = −c − J M⁻¹ F                                                               (B31)
  /// Stops that a joint rests against, and that push, keep it through the step                     (B34)
  /// @param at              fraction of the step
  /// @param state, force_N, torque_N_m  column 0 is the block's first body
  void add_loads(const BodyBlock& block, const BlockState& state, double at, BlockVectors& force_N,
                 BlockVectors& torque_N_m, Work& work) const;

  /// Moves the bodies of a block by M⁻¹ Jᵀ μ until C = 0, and changes their velocities alike until
  /// J (v, ω) + b = 0                                                                             (B32)
  /// A joint that has passed a limit in the step meets the stop where it did                       (B34)
  /// @param state  of all bodies
  /// @param at     fraction of the step
  /// @throws SolverError if the errors do not vanish
  void correct(const BodyBlock& block, double at, MotionState& state, std::int64_t step, Work& work) const;

  /// What joints take from the inverse effective mass of a contact, for a row g of its two bodies
  ///   1/m_eff = g M⁻¹ gᵀ − (g M⁻¹ Jᵀ) (J M⁻¹ Jᵀ)⁻¹ (J M⁻¹ gᵀ)                                          (B20)
  /// Stops that a joint rests against count if they push.
  /// @param bodies  of the contact; −1: a wall
  /// @param at      fraction of the step
  [[nodiscard]] double inverse_mass_taken_per_kg(const std::array<int, 2>& bodies, const JointRow& contact, double at,
                                                 const MotionState& state, Work& work) const;

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
    Eigen::Index block_key;   ///< a body of it that moves
    std::vector<int> bodies;  ///< that move
    std::vector<Joint> joints;
    Eigen::Index rows = 0;
  };
  /// How a joint is to the nearer of its limits.
  struct Reach {
    int stop = 0;         ///< as in Work; 0: there are no limits
    double beyond = 0.0;  ///< the limit [m], of a hinge [rad]
    double rate = 0.0;    ///< of change of that
    double negligible = 0.0;
  };

  [[nodiscard]] std::span<const Island> islands_of(const BodyBlock& block) const;
  [[nodiscard]] JointMotion motion(const Joint& joint, double at) const;
  template <class State>
  [[nodiscard]] JointSide side(int body, Eigen::Index first, const State& state) const;
  [[nodiscard]] bool moves(int body) const { return body >= 0 && model_.moves(body); }
  /// Calls act(end, body) for each end of a joint whose body moves.
  void for_each_moving(const Joint& joint, const auto& act) const {
    for (const int end : {0, 1})
      if (moves(joint.bodies[end])) act(end, joint.bodies[end]);
  }
  /// How loads accelerate a body, and its rotation, as its kind of motion allows.
  [[nodiscard]] std::pair<Eigen::Vector3d, Eigen::Vector3d> answer(int body, const JointSide& side,
                                                                   Eigen::Vector3d force_N,
                                                                   Eigen::Vector3d torque_N_m) const;
  template <class State>
  void list_rows(const Island& island, Eigen::Index first, double at, const State& state, Work& work) const;
  void add_springs(const Island& island, Eigen::Index first, const Work& work, BlockVectors& force_N,
                   BlockVectors& torque_N_m) const;
  void factorise(const Island& island, Work& work) const;
  static void solve(Work& work);
  void correct(const Island& island, double at, MotionState& state, std::int64_t step, Work& work) const;
  template <class State>
  [[nodiscard]] Reach reach(const Joint& joint, Eigen::Index first, const State& state) const;
  template <class State>
  [[nodiscard]] int stop_at_rest(const Joint& joint, Eigen::Index first, const State& state) const;
  void meet_stops(const Island& island, double at, MotionState& state, Work& work) const;
  void drift(const Island& island, double duration_s, MotionState& state) const;
  [[nodiscard]] bool release(const Island& island, double least, Work& work) const;
  [[nodiscard]] JointRow stop_row(const Joint& joint, int stop, const std::array<JointSide, 2>& sides) const;
  /// @throws SolverError if the rows have errors that Newton's method did not remove
  [[nodiscard]] const Joint* open_joint(const Island& island, const Work& work) const;
  void correct_positions(const Island& island, const Work& work, MotionState& state) const;
  void correct_velocities(const Island& island, double at, Work& work, MotionState& state) const;

  const BodyModel& model_;
  std::vector<Island> islands_;  ///< by key
  std::vector<int> island_of_;   ///< of each body; −1: none
  Eigen::MatrixX3d nodes_;       ///< values of the actuators in the step; no rows: nothing has moved yet
  double step_s_ = 0.0;
};

}  // namespace copepod::body
