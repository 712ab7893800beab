#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "contract/body_setup.hpp"
#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "geometry/rotation.hpp"

namespace copepod {

/// F_B of (B17) for a line d between the ends.
template <class Vector>  // of three components; plain numbers, so that loops over pairs are vectorised
Vector pair_force(double value, const Vector& d) {
  const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
  return {value * (d[0] / length), value * (d[1] / length), value * (d[2] / length)};
}

/// Of a pair force, which then has no direction.
inline SolverError coinciding_ends(int body_A, int body_B) {
  return SolverError("the ends of the pair force between bodies " + std::to_string(body_A) + " and " +
                     std::to_string(body_B) +
                     " (counted from 0) coincide (it has no direction). Start its ends apart.");
}

/// Adds the force and the torque about the centre of mass that an actuator of value s exerts on its bodies:
///   pair_force              F_B = s e,  F_A = −F_B,  τ = r × F at both ends                              (B17)
///                           e = d/|d|,  d = (p_B + r_B) − (p_A + r_A),  r = R anchor
///   body_force, body_torque F = s R a,  τ = s R a                                                        (B18)
///   world_force, world_torque  F = s a,  τ = s a
///   joint_motion, control   nothing that is known here: joints exert what their motion takes
/// A positive pair force pushes the bodies apart; whatever their motion, its net force is exactly zero and its
/// net torque zero within rounding, as both act along the line through both ends.
/// @param value        s [N], of a torque [N m]; 0: nothing is added
/// @param first        number of the body in column 0 of the arrays
/// @param position_m, orientation_wxyz  current, world frame, shapes (3, bodies) and (4, bodies)
/// @param force_N, torque_N_m           sums to add to, world frame, shape (3, bodies)
/// @throws SolverError if the ends of a pair coincide (no direction)
inline void add_actuator_loads(const ActuatorSpecification& actuator, double value, Eigen::Index first,
                               const auto& position_m, const auto& orientation_wxyz, auto& force_N, auto& torque_N_m) {
  if (value == 0.0) return;
  const Eigen::Index A = actuator.body_A - first;
  const Eigen::Index B = actuator.body_B - first;
  Eigen::Vector3d direction_W = actuator.direction;
  switch (actuator.kind) {
    case ActuatorKind::pair_force: {
      Eigen::Vector3d d_AB_W_m = position_m.col(B) - position_m.col(A);
      const bool anchored = !actuator.anchor_A_m.isZero(0.0) || !actuator.anchor_B_m.isZero(0.0);
      Eigen::Vector3d r_A_W_m, r_B_W_m;
      if (anchored) {
        r_A_W_m = rotation_matrix(orientation_wxyz.col(A)) * actuator.anchor_A_m;
        r_B_W_m = rotation_matrix(orientation_wxyz.col(B)) * actuator.anchor_B_m;
        d_AB_W_m += r_B_W_m - r_A_W_m;
      }
      if (d_AB_W_m.isZero(0.0)) throw coinciding_ends(actuator.body_A, actuator.body_B);
      const Eigen::Vector3d f_B_W_N = pair_force(value, d_AB_W_m);
      force_N.col(A) -= f_B_W_N;
      force_N.col(B) += f_B_W_N;
      if (!anchored) return;
      torque_N_m.col(A) -= r_A_W_m.cross(f_B_W_N);
      torque_N_m.col(B) += r_B_W_m.cross(f_B_W_N);
      return;
    }
    case ActuatorKind::body_force:
    case ActuatorKind::body_torque:
      direction_W = rotation_matrix(orientation_wxyz.col(A)) * actuator.direction;
      break;
    case ActuatorKind::world_force:
    case ActuatorKind::world_torque:
      break;
    case ActuatorKind::joint_motion:
    case ActuatorKind::control:
      return;
  }
  const bool is_force = actuator.kind == ActuatorKind::body_force || actuator.kind == ActuatorKind::world_force;
  (is_force ? force_N : torque_N_m).col(A) += value * direction_W;
}

/// Loads of the whole drive on all bodies.
/// @param values  of every actuator, one column of AppliedLoads::actuation
/// @param drive   resized and overwritten
/// @throws SolverError if the ends of a pair coincide
inline void drive_loads(const std::vector<ActuatorSpecification>& actuators,
                        const Eigen::Ref<const Eigen::VectorXd>& values, const Kinematics& kinematics, Loads& drive) {
  drive.step = kinematics.step;
  drive.force_N.setZero(3, kinematics.bodies());
  drive.torque_N_m.setZero(3, kinematics.bodies());
  for (std::size_t i = 0; i < actuators.size(); ++i)
    add_actuator_loads(actuators[i], values[i], 0, kinematics.position_m, kinematics.orientation_wxyz, drive.force_N,
                       drive.torque_N_m);
}

}  // namespace copepod
