#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "forces/force_element.hpp"

namespace copepod::body {

/// Force with which a spring and damper pull their ends together [N]: k (|d| − l₀) + γ ḋ·e of (B6)
/// @param e                  unit vector along it, world frame
/// @param ddot_AB_W_m_per_s  velocity of end B less that of end A, world frame [m/s]
template <class Vector>
double tension_N(const SpringSpecification& spring, double length_m, const Vector& e, const Vector& ddot_AB_W_m_per_s) {
  const Vector& u = ddot_AB_W_m_per_s;
  return spring.stiffness_N_per_m * (length_m - spring.rest_length_m) +
         spring.damping_N_s_per_m * (u[0] * e[0] + u[1] * e[1] + u[2] * e[2]);
}

/// Force of a spring and damper on its end A, along the line between its ends:
///   F_A = (k (|d| − l₀) + γ ḋ·e) e,   d = A to B, e = d/|d|             [paper, eqs. (5), (6)]     (B6)
/// The paper's swimmers move on a line, where its vectors Δx and Δu have this one component. Off a line the
/// damping, too, acts along the spring only: a damper across it would brake rigid rotations and create
/// angular momentum.
/// @param d_AB_W_m          from end A to end B, world frame [m]
/// @param ddot_AB_W_m_per_s  its rate of change [m/s]
/// @return force on A, world frame [N]; B receives the negative. NaN if the ends coincide (no direction).
inline Eigen::Vector3d spring_force(const SpringSpecification& spring, const Eigen::Vector3d& d_AB_W_m,
                                    const Eigen::Vector3d& ddot_AB_W_m_per_s) {
  const Eigen::Vector3d& d = d_AB_W_m;
  const double length_m = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  const Eigen::Vector3d e = d / length_m;
  return tension_N(spring, length_m, e, ddot_AB_W_m_per_s) * e;
}

/// All springs of a case.
class Springs final : public ForceElement {
 public:
  /// Force of one spring, and where it acts; world frame.
  struct Pull {
    Eigen::Vector3d r_A_W_m;   ///< from A's centre of mass to its anchor
    Eigen::Vector3d r_B_W_m;   ///< from B's centre of mass to its anchor
    Eigen::Vector3d d_AB_W_m;  ///< from A's anchor to B's
    Eigen::Vector3d f_A_W_N;   ///< on A; B receives the negative
  };

  /// @throws CaseError if a spring connects bodies that do not exist, or a body to itself, or has a negative
  ///         stiffness, damping or rest length
  explicit Springs(const BodySetup& setup);

  /// Adds the springs' loads spring by spring, in the order of the setup.
  /// @throws SolverError naming both bodies if the ends of a spring coincide
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

  /// Pull of spring number `index`:
  ///   d = (p_B + r_B) − (p_A + r_A),   ḋ = (v_B + ω_B × r_B) − (v_A + ω_A × r_A),   r = R anchor    (B7)
  ///   force ±F of (B6) at the anchors, torque r × F about the centre of mass
  /// @param first  body of column 0 of `state` and `w_WB_rad_per_s`
  /// @throws SolverError naming both bodies if the anchors coincide
  [[nodiscard]] Pull pull(std::size_t index, Eigen::Index first, const BlockState& state,
                          const BlockVectors& w_WB_rad_per_s) const;

 private:
  void add_anchored(std::size_t index, const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const;
  [[noreturn]] void fail(const SpringSpecification& spring) const;

  std::vector<SpringSpecification> springs_;
  std::vector<std::string> names_;  ///< of the bodies, for errors
};

/// All bends of a case: angular springs that keep the angle θ at body B between its arms a = p_A − p_B and
/// c = p_C − p_B near the rest angle,
///   E = κ (θ − θ₀)²/2,   F_A = κ (θ − θ₀) t_a/|a|,   F_C = κ (θ − θ₀) t_c/|c|,   F_B = −F_A − F_C          (B19)
/// with the unit vectors t_a and t_c across the arms, in their plane, towards the other arm.
class Bends final : public ForceElement {
 public:
  /// @throws CaseError if a bend joins bodies that do not exist or are not three, has a negative stiffness, or a rest
  ///         angle outside [0, π]
  explicit Bends(const BodySetup& setup);

  /// @throws SolverError naming the bodies if two of them coincide, or if their arms are parallel and the rest angle
  ///         is another one (the forces have no direction)
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

 private:
  [[noreturn]] void fail(const BendSpecification& bend) const;

  std::vector<BendSpecification> bends_;
  std::vector<std::string> names_;  ///< of the bodies, for errors
};

}  // namespace copepod::body
