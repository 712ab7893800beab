#pragma once

#include <Eigen/Core>

namespace copepod::body {

/// Linear spring with linear damper.
struct SpringLaw {
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
  double rest_length_m = 0.0;
};

/// Force of a spring and damper on its end A, along the line between its ends:
///   F_A = (k (|d| − l₀) + γ ḋ·e) e,   d = A to B, e = d/|d|             [paper, eqs. (5), (6)]     (B6)
/// The paper's swimmers move on a line, where its vectors Δx and Δu have this one component. Off a line the
/// damping, too, acts along the spring only: a damper across it would brake rigid rotations and create
/// angular momentum from nothing.
/// @param d_AB_W_m          from end A to end B, world frame [m]
/// @param ddot_AB_W_m_per_s  its rate of change [m/s]
/// @return force on A, world frame [N]; B receives the negative. NaN if the ends coincide (no direction).
inline Eigen::Vector3d spring_force(const SpringLaw& law, const Eigen::Vector3d& d_AB_W_m,
                                    const Eigen::Vector3d& ddot_AB_W_m_per_s) {
  const double length_m = d_AB_W_m.norm();
  const Eigen::Vector3d direction = d_AB_W_m / length_m;
  const double tension_N = law.stiffness_N_per_m * (length_m - law.rest_length_m) +
                           law.damping_N_s_per_m * ddot_AB_W_m_per_s.dot(direction);
  return tension_N * direction;
}

}  // namespace copepod::body
