#pragma once

#include <cmath>

#include <Eigen/Core>

namespace copepod {

/// Rotation matrix R_WB of a unit quaternion (w, x, y, z): p_W = R_WB p_B.
inline Eigen::Matrix3d rotation_matrix(const Eigen::Vector4d& q) {
  const double w = q[0];
  const double x = q[1];
  const double y = q[2];
  const double z = q[3];
  Eigen::Matrix3d R_WB;
  R_WB << 1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),  //
      2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),      //
      2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y);
  return R_WB;
}

/// Direction of the body's z axis in the world: third column of the rotation matrix.
inline Eigen::Vector3d z_axis(const Eigen::Vector4d& q) {
  return {2 * (q[1] * q[3] + q[0] * q[2]), 2 * (q[2] * q[3] - q[0] * q[1]), 1 - 2 * (q[1] * q[1] + q[2] * q[2])};
}

/// Product (0, w) ⊗ q of a vector, taken as a pure quaternion, and a quaternion.
template <class Vector3, class Vector4>  // plain numbers, so that loops over bodies are vectorised
Vector4 pure_product(const Vector3& w, const Vector4& q) {
  return {-w[0] * q[1] - w[1] * q[2] - w[2] * q[3], w[0] * q[0] + w[1] * q[3] - w[2] * q[2],
          w[1] * q[0] + w[2] * q[1] - w[0] * q[3], w[2] * q[0] + w[0] * q[2] - w[1] * q[1]};
}

/// Product p ⊗ q: the rotation q followed by p.
inline Eigen::Vector4d product(const Eigen::Vector4d& p, const Eigen::Vector4d& q) {
  return p[0] * q + pure_product(Eigen::Vector3d(p.tail<3>()), q);
}

/// Rate of change of the orientation,
///   dq/dt = 1/2 (0, ω) ⊗ q,   ω in the world frame                                   (B10)
template <class Vector3, class Vector4>
Vector4 orientation_rate(const Vector3& w_WB_rad_per_s, const Vector4& q_WB) {
  const Vector4 twice = pure_product(w_WB_rad_per_s, q_WB);
  return {0.5 * twice[0], 0.5 * twice[1], 0.5 * twice[2], 0.5 * twice[3]};
}

/// Orientation after turning by the rotation vector `angle_rad` (world frame): q' = exp(θ/2) ⊗ q      (B15)
inline Eigen::Vector4d rotated(const Eigen::Vector3d& angle_rad, const Eigen::Vector4d& q) {
  const double half = 0.5 * angle_rad.norm();
  // Below this angle, sin(x)/x and its series 1 − x²/6 agree to the last bit; at rest the quotient is 0/0.
  const double sinc = half < 1e-5 ? 1.0 - half * half / 6.0 : std::sin(half) / half;
  return std::cos(half) * q + (0.5 * sinc) * pure_product(angle_rad, q);
}

}  // namespace copepod
