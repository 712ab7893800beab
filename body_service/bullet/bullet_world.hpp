#pragma once

#include <btBulletDynamicsCommon.h>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "bullet/bullet_shapes.hpp"
#include "contract/body_setup.hpp"
#include "engine/engine_world.hpp"
#include "forces/springs.hpp"
#include "model/body_model.hpp"

namespace copepod::body {

/// A pull of given strength between two points, as one row of Bullet's constraint solver: the impulse λ along
/// e acts on A, −λ on B, and both limits of λ are the impulse of the pull over the step. So contacts and
/// joints are solved together with the springs.
///
/// Bullet's own spring constraints (6Dof, 6DofSpring2) are motors: their row stops pulling once the two
/// bodies have the relative velocity that this spring alone would give them. In a row of three beads, where
/// the middle one is pulled by two springs, the error is a factor that does not decrease with the step; see
/// docs/decisions/engines.md.
class SpringConstraint final : public btTypedConstraint {
 public:
  SpringConstraint(btRigidBody& A, btRigidBody& B) : btTypedConstraint(MAX_CONSTRAINT_TYPE, A, B) {}

  /// @param force      on A along `direction`, Bullet's units; pulls if positive
  /// @param direction  unit vector from A's end to B's
  /// @param arm_A      from A's centre of mass to its end, world frame
  void set_pull(btScalar force, const btVector3& direction, const btVector3& arm_A, const btVector3& arm_B) {
    force_ = force;
    direction_ = direction;
    arm_A_ = arm_A;
    arm_B_ = arm_B;
  }

  void getInfo1(btConstraintInfo1* info) override {
    info->m_numConstraintRows = 1;
    info->nub = 5;
  }

  void getInfo2(btConstraintInfo2* info) override {
    write(direction_, info->m_J1linearAxis);
    write(arm_A_.cross(direction_), info->m_J1angularAxis);
    write(-direction_, info->m_J2linearAxis);
    write(-arm_B_.cross(direction_), info->m_J2angularAxis);
    const btScalar impulse = force_ / info->fps;
    info->m_lowerLimit[0] = impulse;
    info->m_upperLimit[0] = impulse;
  }

  void setParam(int, btScalar, int) override {}
  [[nodiscard]] btScalar getParam(int, int) const override { return 0.0; }

 private:
  static void write(const btVector3& vector, btScalar* row) {
    for (int i = 0; i < 3; ++i) row[i] = vector[i];
  }

  btScalar force_ = 0.0;
  btVector3 direction_{0, 0, 1};
  btVector3 arm_A_{0, 0, 0};
  btVector3 arm_B_{0, 0, 0};
};

/// The bodies, springs and walls of a case in Bullet.
///
/// Bullet keeps the contacts and the order of neighbours of former steps. Here every step starts from a fresh
/// world made of the state alone, so that the next state is a function of state and loads: a restart gives
/// the same bits.
class BulletWorld final : public EngineWorld {
 public:
  BulletWorld(const BodySetup& setup, const BodyModel& model, double step_s);

  [[nodiscard]] bool has_springs() const override { return true; }

  /// One step of semi-implicit Euler with constraints, v' = v + h F/m, x' = x + h v'.
  void advance(Kinematics& state, const Loads& loads) override;

 private:
  void add_body(Eigen::Index body, const BodySpecification& specification);
  void add_wall(const WallSpecification& wall);
  void add_joint(Eigen::Index body, const Kinematics& start);
  void give_contact_properties(btRigidBody& body, double restitution, double friction) const;
  void configure(btDiscreteDynamicsWorld& world, const Loads& loads) const;
  void place(Eigen::Index body, const Kinematics& state);
  void read(Eigen::Index body, Kinematics& state) const;

  const BodyModel& model_;
  EngineUnits units_;
  ContactSpecification contact_;
  double friction_of_a_body_;  ///< Bullet multiplies those of two bodies
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  ShapeOnPlane::CreateFunc shape_and_plane_, plane_and_shape_;
  BulletShapes shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;  ///< in their principal frames, as Bullet requires
  std::vector<btQuaternion> q_BP_;                    ///< of these
  std::vector<std::unique_ptr<btRigidBody>> walls_;
  std::vector<std::unique_ptr<btTypedConstraint>> joints_;  ///< of bodies with motion: axis
  Springs springs_;
  std::vector<std::unique_ptr<SpringConstraint>> pulls_;  ///< of the springs, in their order
};

}  // namespace copepod::body
