#pragma once

#include <Eigen/Core>

namespace copepod::body {

/// State of motion of a row of bodies, or its rate of change; SI units, world frame, one column per body.
///
/// The rotation is carried as angular momentum: it changes by torques only (B9), so that torque-free motion
/// keeps it to the last bit and the gyroscopic term ω × Iω needs no code of its own. A body that torques do
/// not turn (fixed, prescribed) has unit inertia here, so that its column holds the angular velocity.
struct MotionState {
  Eigen::Matrix3Xd position_m;
  Eigen::Matrix4Xd orientation_wxyz;
  Eigen::Matrix3Xd velocity_m_per_s;
  Eigen::Matrix3Xd angular_momentum_N_m_s;

  [[nodiscard]] Eigen::Index bodies() const { return position_m.cols(); }
  void resize(Eigen::Index bodies) {
    position_m.resize(3, bodies);
    orientation_wxyz.resize(4, bodies);
    velocity_m_per_s.resize(3, bodies);
    angular_momentum_N_m_s.resize(3, bodies);
  }
};

}  // namespace copepod::body
