#pragma once

#include <array>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "contract/shape.hpp"

namespace copepod {

enum class MotionKind {
  free,        ///< six degrees of freedom
  fixed,       ///< never moves
  prescribed,  ///< keeps its given velocities
  axis,        ///< translates along, and rotates about, `axis` only
};

enum class Integrator {
  semi_implicit_euler,  ///< the paper's
  runge_kutta_4,        ///< classical, driving forces sampled at 0, 1/2 and 1 of the step
};

/// One rigid body of uniform density; its initial state is in SI units and the world frame.
struct BodySpecification {
  std::string name;
  Shape shape;
  double mass_kg = 0.0;
  MotionKind motion = MotionKind::free;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit vector, for MotionKind::axis
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector4d orientation_wxyz = Eigen::Vector4d(1, 0, 0, 0);
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_rad_per_s = Eigen::Vector3d::Zero();
};

/// Spring and damper between an anchor on body A and one on body B [paper, eqs. (5), (6)].
struct SpringSpecification {
  int body_A = 0;
  int body_B = 0;
  double stiffness_N_per_m = 0.0;
  double damping_N_s_per_m = 0.0;
  double rest_length_m = 0.0;
  Eigen::Vector3d anchor_A_m = Eigen::Vector3d::Zero();  ///< in the frame of A, from its centre of mass
  Eigen::Vector3d anchor_B_m = Eigen::Vector3d::Zero();  ///< in the frame of B
};

/// Everything that a body solver needs before the first step; SI units.
struct BodySetup {
  double step_s = 0.0;
  Integrator integrator = Integrator::runge_kutta_4;
  Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d::Zero();
  double fluid_density_kg_per_m3 = 0.0;       ///< for buoyancy: weight is (m − ρ V) g
  std::array<double, 3> periodic_length_m{};  ///< 0: not periodic; distances of overlap checks use nearest images
  std::vector<BodySpecification> bodies;
  std::vector<SpringSpecification> springs;
  std::string trace_directory;  ///< absolute; where phases are recorded; empty: nowhere
};

}  // namespace copepod
