#pragma once

#include <btBulletDynamicsCommon.h>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "bullet/bullet_units.hpp"
#include "bullet/spring_constraint.hpp"
#include "contract/body_setup.hpp"
#include "forces/springs.hpp"
#include "model/body_model.hpp"

namespace copepod::body {

/// State of motion as Bullet carries it; SI units, world frame, one column per body.
struct BulletState {
  Eigen::Matrix3Xd position_m;
  Eigen::Matrix4Xd orientation_wxyz;
  Eigen::Matrix3Xd velocity_m_per_s;
  Eigen::Matrix3Xd angular_velocity_rad_per_s;
};

/// The bodies, springs and joints of a case in Bullet.
///
/// Bullet keeps the contacts and the order of neighbours of former steps. Here every step starts from a fresh
/// world made of the state alone, so that the next state is a function of state and loads: a restart gives
/// the same bits.
class BulletWorld {
 public:
  BulletWorld(const BodySetup& setup, const BodyModel& model);

  /// One step of semi-implicit Euler with constraints, v' = v + h F/m, x' = x + h v', under constant loads.
  /// @param force_N, torque_N_m  on every body, springs excepted; finite
  void advance(BulletState& state, const Eigen::Matrix3Xd& force_N, const Eigen::Matrix3Xd& torque_N_m);

 private:
  void add_body(Eigen::Index body);
  void add_joint(Eigen::Index body, const BulletState& start);
  void place(Eigen::Index body, const BulletState& state);
  void read(Eigen::Index body, BulletState& state) const;

  const BodyModel& model_;
  BulletUnits units_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;  ///< of bodies with motion: axis
  Springs springs_;
  std::vector<std::unique_ptr<SpringConstraint>> pulls_;  ///< of the springs, in their order
};

/// State in which a case starts.
BulletState initial_state(const BodyModel& model);

/// Bullet's state in the form in which states are stored, digested and passed to force elements; the last
/// columns hold angular velocities.
MotionState as_motion_state(const BulletState& state);

}  // namespace copepod::body
