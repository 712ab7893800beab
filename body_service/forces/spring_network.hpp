#pragma once

#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "forces/spring.hpp"
#include "model/body_block.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// All springs of a case.
class SpringNetwork {
 public:
  /// @throws CaseError if a spring connects bodies that do not exist, or a body to itself, or has a negative
  ///         stiffness, damping or rest length
  explicit SpringNetwork(const BodySetup& setup);

  /// Adds the springs' forces and torques on the bodies of a block, spring by spring in the order of the
  /// setup:
  ///   d = (p_B + r_B) − (p_A + r_A),   ḋ = (v_B + ω_B × r_B) − (v_A + ω_A × r_A),   r = R anchor    (B7)
  ///   force ±F of (B6) at the anchors, torque r × F about the centre of mass
  /// @param state             of the block's bodies, column 0 is body block.first
  /// @param w_WB_rad_per_s    their angular velocities, shape (3, ≥ bodies)
  /// @param force_N, torque_N_m  sums to add to, shape (3, ≥ bodies)
  /// @throws SolverError naming both bodies if the ends of a spring coincide
  void add_loads(const BodyBlock& block, const MotionState& state, const Eigen::Matrix3Xd& w_WB_rad_per_s,
                 Eigen::Matrix3Xd& force_N, Eigen::Matrix3Xd& torque_N_m) const;

 private:
  struct Spring {
    int body_A;
    int body_B;
    SpringLaw law;
    bool anchored;  ///< false: both anchors are the centres of mass
    Eigen::Vector3d anchor_A_m;
    Eigen::Vector3d anchor_B_m;
  };

  void add_anchored(const Spring& spring, Eigen::Index A, Eigen::Index B, const MotionState& state,
                    const Eigen::Matrix3Xd& w, Eigen::Matrix3Xd& force_N, Eigen::Matrix3Xd& torque_N_m) const;
  [[nodiscard]] Eigen::Vector3d force_of(const Spring& spring, const Eigen::Vector3d& d_AB_W_m,
                                         const Eigen::Vector3d& ddot_AB_W_m_per_s) const;

  std::vector<Spring> springs_;
  std::vector<std::string> names_;  ///< of the bodies, for errors
};

}  // namespace copepod::body
