#pragma once

#include <array>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "contract/shape.hpp"

namespace copepod {

/// How a body moves.
enum class MotionKind {
  free,        ///< six degrees of freedom
  fixed,       ///< never moves
  prescribed,  ///< keeps its given velocities
  axis,        ///< translates along, and rotates about, `axis` only
};

/// How bodies are advanced by a step.
enum class Integrator {
  semi_implicit_euler,  ///< the paper's
  runge_kutta_4,        ///< classical, the drive sampled at 0, 1/2 and 1 of the step
};

/// What an actuator exerts, or moves.
enum class ActuatorKind {
  pair_force,    ///< pushes two bodies apart along the line between its ends
  body_force,    ///< on the centre of mass, in a direction fixed to the body
  body_torque,   ///< about a direction fixed to the body
  world_force,   ///< on the centre of mass, in a direction fixed in the world
  world_torque,  ///< about a direction fixed in the world
  joint_motion,  ///< what a hinge, slider or rod has moved since the start
  control,       ///< input of an actuator of the model, by its name
};

/// What a joint keeps.
enum class JointKind {
  ball,      ///< one point in common
  hinge,     ///< a point and the direction of an axis in common
  slider,    ///< moves along an axis without turning
  fixed,     ///< no relative motion
  distance,  ///< two points keep their distance: a rod without mass
  model,     ///< as the model has it: the bodies may overlap
};

/// Whether JointSpecification::axis matters.
constexpr bool has_axis(JointKind kind) { return kind == JointKind::hinge || kind == JointKind::slider; }

/// One rigid body; its initial state is in SI units and the world frame.
struct BodySpecification {
  std::string name;                   ///< unique, for people
  Shape shape;                        ///< in the body's frame
  double mass_kg = 0.0;               ///< positive
  std::vector<double> inertia_kg_m2;  ///< about the centre of mass, body frame: xx, yy, zz, xy, xz, yz; none: uniform
  MotionKind motion = MotionKind::free;                                  ///< how it moves
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();                       ///< unit vector, for MotionKind::axis
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();                  ///< centre of mass p_WB
  Eigen::Vector4d orientation_wxyz = Eigen::Vector4d(1, 0, 0, 0);        ///< unit quaternion q_WB
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();            ///< v_WB
  Eigen::Vector3d angular_velocity_rad_per_s = Eigen::Vector3d::Zero();  ///< w_WB
};

/// Inertia tensor about the centre of mass, in the body frame [kg m²].
inline Eigen::Matrix3d inertia_tensor_kg_m2(const BodySpecification& body) {
  const std::vector<double>& I = body.inertia_kg_m2;
  if (I.empty()) return inertia_tensor_kg_m2(body.shape, body.mass_kg);
  return Eigen::Matrix3d{{I[0], I[3], I[4]}, {I[3], I[1], I[5]}, {I[4], I[5], I[2]}};
}

/// Spring and damper between an anchor on body A and one on body B [paper, eqs. (5), (6)].
struct SpringSpecification {
  int body_A = 0;                                        ///< index of a body
  int body_B = 0;                                        ///< index of another
  double stiffness_N_per_m = 0.0;                        ///< k
  double damping_N_s_per_m = 0.0;                        ///< γ
  double rest_length_m = 0.0;                            ///< l₀, between the anchors
  Eigen::Vector3d anchor_A_m = Eigen::Vector3d::Zero();  ///< in the frame of A, from its centre of mass
  Eigen::Vector3d anchor_B_m = Eigen::Vector3d::Zero();  ///< in the frame of B
};

/// Angular spring at body B between its arms to A and C; torque-free and force-free.
struct BendSpecification {
  int body_A = 0;                            ///< end of an arm
  int body_B = 0;                            ///< the vertex
  int body_C = 0;                            ///< end of the other
  double stiffness_N_m_per_rad = 0.0;        ///< of the spring
  double rest_angle_rad = std::numbers::pi;  ///< π: straight
};

/// Ideal joint of two bodies, or of a body and the world; the bodies' initial places determine what it keeps.
struct JointSpecification {
  JointKind kind = JointKind::ball;                      ///< what it keeps
  int body_A = 0;                                        ///< index of a body
  int body_B = -1;                                       ///< −1: the world
  Eigen::Vector3d anchor_A_m = Eigen::Vector3d::Zero();  ///< in the frame of A, from its centre of mass
  Eigen::Vector3d anchor_B_m = Eigen::Vector3d::Zero();  ///< in the frame of B; of the world: a place
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();       ///< of hinge and slider: unit vector, frame of A
  double stiffness = 0.0;                                ///< of a spring along their motion [N m/rad], [N/m]
  double damping = 0.0;                                  ///< of a damper beside it [N m s/rad], [N s/m]
  double rest = 0.0;                                     ///< where the spring is relaxed, from the start [rad], [m]
  double lowest = 0.0;                                   ///< limits of their motion from the start [rad], [m];
  double highest = 0.0;                                  ///< both 0: none

  [[nodiscard]] bool has_limits() const { return lowest != 0.0 || highest != 0.0; }  ///< of its motion
};

/// Whether a joint can be driven: it has one motion.
constexpr bool has_motion(JointKind kind) { return has_axis(kind) || kind == JointKind::distance; }

/// Part of the drive: what it exerts per unit of its value, which every step brings anew (AppliedLoads::actuation);
/// geometry/actuator_loads.hpp has the equations. Of a joint the value is what it has moved since the start: the angle
/// by which A has turned relative to B [rad], how far A has slid along the axis [m], or how much longer a rod is [m].
/// Of a control it is the input at the end of the step, in the units of the model.
struct ActuatorSpecification {
  ActuatorKind kind = ActuatorKind::pair_force;  ///< what it exerts
  int body_A = 0;                                ///< index of the body that it acts on
  int body_B = -1;                               ///< of a pair; −1: none
  Eigen::Vector3d direction =
      Eigen::Vector3d::UnitZ();  ///< unit vector, frame of the body or of the world; not of a pair
  Eigen::Vector3d anchor_A_m = Eigen::Vector3d::Zero();  ///< end of a pair in the frame of A, from its centre of mass
  Eigen::Vector3d anchor_B_m = Eigen::Vector3d::Zero();  ///< in the frame of B
  int joint = -1;                                        ///< of a joint_motion; −1: none
  std::string control = {};                              ///< name of a control; it acts on no body of its own
};

/// Plane wall of the domain, which bodies meet in contacts, or an exit. A body without springs, joints and actuators
/// whose bounding ball reaches an exit is placed behind it, apart from all others, and rests there from the next step
/// on; in this one it keeps its velocity.
struct WallSpecification {
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();           ///< on the plane
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();           ///< unit vector towards the bodies
  Eigen::Vector3d velocity_m_per_s = Eigen::Vector3d::Zero();  ///< of its surface, in its plane
  double friction = 0.0;                                       ///< Coulomb coefficient between it and bodies
  bool removes_bodies = false;                                 ///< an exit
};

/// Contacts between bodies, and between bodies and walls.
struct ContactSpecification {
  double stiffness_N_per_m = 0.0;  ///< of the normal spring; 0: contacts are not resolved
  double restitution = 1.0;        ///< ratio of normal velocities after and before an impact, at most 1
  double friction = 0.0;           ///< Coulomb coefficient between bodies
};

/// Bodies as a model of a rigid-body engine, with joints, tendons and actuators of its own.
struct ModelSpecification {
  std::string text = {};  ///< MJCF [MuJoCo 2.2, "XML reference"]; empty: none
  double length_m = 1.0;  ///< its unit of length
  double mass_kg = 1.0;   ///< its unit of mass
  double time_s = 1.0;    ///< its unit of time
};

constexpr int most_threads = 1024;  ///< of a body solver

/// Everything that a body solver needs before the first step; SI units.
struct BodySetup {
  double step_s = 0.0;                                         ///< of the coupling
  Integrator integrator = Integrator::runge_kutta_4;           ///< of bodies without an engine
  Eigen::Vector3d gravity_m_per_s2 = Eigen::Vector3d::Zero();  ///< g; 0: weightless
  double fluid_density_kg_per_m3 = 0.0;                        ///< for buoyancy: weight is (m − ρ V) g
  std::array<double, 3> periodic_length_m{};     ///< 0: not periodic; distances of overlap checks use nearest images
  std::vector<BodySpecification> bodies;         ///< in the order of Kinematics and Loads
  std::vector<SpringSpecification> springs;      ///< with their dampers
  std::vector<BendSpecification> bends;          ///< angular springs
  std::vector<JointSpecification> joints;        ///< in the order of ActuatorSpecification::joint
  std::vector<ActuatorSpecification> actuators;  ///< in the order of AppliedLoads::actuation
  std::vector<WallSpecification> walls;          ///< for contacts, and exits
  ContactSpecification contact;                  ///< between bodies, and with `walls`
  ModelSpecification model;                      ///< its spheres and capsules are `bodies`, in its order
  int threads = 1;                               ///< in which the solver may compute; results do not depend on it
  std::string trace_directory;                   ///< absolute; where phases are recorded; empty: nowhere
  std::string parameters = {};                   ///< JSON, of a component that the case names
};

}  // namespace copepod
