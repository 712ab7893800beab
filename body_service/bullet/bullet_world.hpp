#pragma once

#include <btBulletDynamicsCommon.h>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "bullet/bullet_shapes.hpp"
#include "bullet/spring_constraint.hpp"
#include "contract/body_setup.hpp"
#include "engine/engine_world.hpp"
#include "forces/springs.hpp"
#include "model/body_model.hpp"

namespace copepod::body {

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
