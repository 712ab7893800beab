#pragma once

#include <cstdint>

#include <Eigen/Core>

namespace copepod {

/// State of motion of all bodies at the start of a step; SI units, world frame.
/// Structure of arrays: one column per body, bodies in the order of the setup, so that a message is a memcpy.
struct Kinematics {
  std::int64_t step = 0;                        ///< at the start of this one
  Eigen::Matrix3Xd position_m;                  ///< centre of mass p_WB, shape (3, bodies)
  Eigen::Matrix4Xd orientation_wxyz;            ///< unit quaternion q_WB, shape (4, bodies)
  Eigen::Matrix3Xd velocity_m_per_s;            ///< v_WB, shape (3, bodies)
  Eigen::Matrix3Xd angular_velocity_rad_per_s;  ///< w_WB, shape (3, bodies)

  [[nodiscard]] Eigen::Index bodies() const { return position_m.cols(); }  ///< their number
  void resize(Eigen::Index bodies) {
    position_m.resize(3, bodies);
    orientation_wxyz.resize(4, bodies);
    velocity_m_per_s.resize(3, bodies);
    angular_velocity_rad_per_s.resize(3, bodies);
  }
};

/// Hydrodynamic force on, and torque about the centre of mass of, every body during step `step`; world frame. Those
/// that a fluid returns also have columns for the obstacles with loads, behind those of the bodies.
struct Loads {
  std::int64_t step = 0;        ///< during this one
  Eigen::Matrix3Xd force_N;     ///< shape (3, bodies)
  Eigen::Matrix3Xd torque_N_m;  ///< shape (3, bodies)
  Eigen::VectorXd flow = {};    ///< FluidSetup::flow of the start of the step; nothing in steps without a sample

  [[nodiscard]] Eigen::Index bodies() const { return force_N.cols(); }  ///< their number
  void resize(Eigen::Index bodies) {
    force_N.resize(3, bodies);
    torque_N_m.resize(3, bodies);
  }
};

/// What the coupler applies to the bodies during step `step`: loads that are constant over the step, and the
/// value of every actuator at the nodes inside the step which the body solver asked for
/// (BodySolver::driving_nodes). The bodies apply the values along current directions.
struct AppliedLoads {
  Loads hydrodynamic;         ///< after load averaging
  Eigen::MatrixXd actuation;  ///< [N] or [N m], shape (actuators, nodes), actuators in the order of the setup
};

}  // namespace copepod
