#pragma once

#include <array>

#include <Eigen/Core>

#include "contract/body_setup.hpp"

namespace copepod::body {

/// Place and motion of one side of a joint; the world is at rest at the origin.
struct JointSide {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d R_WB = Eigen::Matrix3d::Identity();
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_per_s = Eigen::Vector3d::Zero();
};

/// What a driven joint has moved since the start, s(t); of joints that are not driven 0.
struct JointMotion {
  double value = 0.0;  ///< [m], of a hinge [rad]
  double rate = 0.0;
  double acceleration = 0.0;
};

/// One equation C(x, q, t) = 0 that a joint imposes:
///   dC/dt = J (v, ω) + b,   d²C/dt² = J (a, α) + c
struct JointRow {
  std::array<Eigen::Vector3d, 2> linear;   ///< J of the velocities of A and B
  std::array<Eigen::Vector3d, 2> angular;  ///< J of their angular velocities
  double error = 0.0;                      ///< C: a length or, of directions, a cosine
  double curvature = 0.0;                  ///< c, of the velocities and of the drive's acceleration
  double drift = 0.0;                      ///< b, of the drive
};

/// The equations of one joint, with what the bodies' initial places determine.
class JointEquations {
 public:
  /// @param specification  checked
  /// @param driven         its motion is given; it has_motion()
  /// @param A, B           the sides at the start of the run
  JointEquations(const JointSpecification& specification, bool driven, const JointSide& A, const JointSide& B);

  [[nodiscard]] int rows() const;

  /// Theory (B26) to (B30).
  /// @param rows  room for rows()
  /// @throws SolverError if the ends of a rod coincide (no direction)
  void evaluate(const JointSide& A, const JointSide& B, const JointMotion& motion, JointRow* rows) const;

  /// What a hinge or slider has moved since the start, as `error`, and how that changes.
  [[nodiscard]] JointRow motion(const JointSide& A, const JointSide& B) const;

 private:
  JointKind kind_;
  bool driven_;
  Eigen::Vector3d anchor_A_m_;
  Eigen::Vector3d anchor_B_m_;
  Eigen::Matrix3d frame_A_;  ///< columns: the joint's axes in the frame of A, the third its axis
  Eigen::Matrix3d frame_B_;  ///< the same axes in the frame of B
  double length_m_ = 0.0;    ///< of a rod
};

}  // namespace copepod::body
