#pragma once

#include <Eigen/Core>

#include "contract/body_setup.hpp"

namespace copepod::body {

struct BodyVelocities {
  Eigen::Vector3d linear_m_per_s;
  Eigen::Vector3d angular_rad_per_s;
};

/// Initial velocities of a body, brought into line with its kind of motion: zero if fixed, along the axis for
/// `axis`.
/// @throws CaseError if the case gives a fixed body a velocity, or an `axis` body one off its axis
BodyVelocities constrained_velocities(const BodySpecification& body);

/// Takes from force and torque what the constraint force of the body's kind of motion balances      (B12)
///   free: nothing;   fixed, prescribed: all;   axis: all but the part along the axis, F → a (a·F)
inline void constrain_loads(MotionKind motion, const Eigen::Vector3d& axis, Eigen::Ref<Eigen::Vector3d> force_N,
                            Eigen::Ref<Eigen::Vector3d> torque_N_m) {
  switch (motion) {
    case MotionKind::free:
      return;
    case MotionKind::axis:
      force_N = axis * axis.dot(force_N);
      torque_N_m = axis * axis.dot(torque_N_m);
      return;
    case MotionKind::fixed:
    case MotionKind::prescribed:
      force_N.setZero();
      torque_N_m.setZero();
      return;
  }
}

}  // namespace copepod::body
