#include "bullet/bullet_world.hpp"

#include <BulletCollision/CollisionDispatch/btConvexPlaneCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <BulletCollision/NarrowPhaseCollision/btPersistentManifold.h>
#include <LinearMath/btConvexHullComputer.h>
#include <algorithm>
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <new>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "forces/forces.hpp"
#include "geometry/rotation.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::body {

namespace {

using BulletShapes = std::vector<std::unique_ptr<btCollisionShape>>;

/// A vector in SI units as Bullet's, divided by the unit it is measured in.
btVector3 to_bullet(const Eigen::Vector3d& vector, double unit = 1.0) {
  return {vector[0] / unit, vector[1] / unit, vector[2] / unit};
}

/// A convex solid as its farthest points; it has no margin.
class ConvexSolid final : public btConvexInternalShape {
 public:
  explicit ConvexSolid(std::unique_ptr<Solid> solid) : solid_(std::move(solid)) {
    m_shapeType = CUSTOM_CONVEX_SHAPE_TYPE;
    m_collisionMargin = 0.0;
  }
  btVector3 localGetSupportingVertexWithoutMargin(const btVector3& v) const override {
    return to_bullet(solid_->support({v.x(), v.y(), v.z()}));
  }
  btVector3 localGetSupportingVertex(const btVector3& v) const override {
    return localGetSupportingVertexWithoutMargin(v);
  }
  void batchedUnitVectorGetSupportingVertexWithoutMargin(const btVector3* vectors, btVector3* points,
                                                         int count) const override {
    for (int i = 0; i < count; ++i) points[i] = localGetSupportingVertexWithoutMargin(vectors[i]);
  }
  void calculateLocalInertia(btScalar /*mass*/, btVector3& inertia) const override { inertia.setZero(); }
  [[nodiscard]] const char* getName() const override { return "ConvexSolid"; }

 private:
  std::unique_ptr<Solid> solid_;
};

double volume_of(const btConvexHullComputer& hull) {
  double six_volumes = 0.0;
  for (int face = 0; face < hull.faces.size(); ++face) {
    const btConvexHullComputer::Edge* const first = &hull.edges[hull.faces[face]];
    const btVector3& apex = hull.vertices[first->getSourceVertex()];
    for (const auto* edge = first->getNextEdgeOfFace(); edge != first; edge = edge->getNextEdgeOfFace())
      six_volumes += apex.triple(hull.vertices[edge->getSourceVertex()], hull.vertices[edge->getTargetVertex()]);
  }
  return six_volumes / 6.0;
}

template <class Made>
Made* keep(std::unique_ptr<Made> made, BulletShapes& kept) {
  kept.push_back(std::move(made));
  return static_cast<Made*>(kept.back().get());
}

btCollisionShape* hull_of(const Shape& shape, double unit_m, const std::string& body, BulletShapes& kept) {
  const Eigen::Matrix3Xd vertices = shape.mesh->vertices_m / unit_m;
  btConvexHullComputer hull;
  hull.compute(vertices.data(), 3 * sizeof(double), static_cast<int>(vertices.cols()), 0.0, 0.0);
  constexpr double rounding = 1e-6;
  const double volume = make_solid(shape, unit_m)->moments().volume;
  if (std::abs(volume_of(hull)) > (1.0 + rounding) * volume)
    throw CaseError("body '" + body +
                    "' has a concave mesh (Bullet moves convex ones). Make it of convex parts, with shape: compound.");
  auto* const made = keep(std::make_unique<btConvexHullShape>(&hull.vertices[0].getX(), hull.vertices.size()), kept);
  made->setMargin(0.0);
  made->initializePolyhedralFeatures();  // contacts of whole faces
  return made;
}

/// Bullet's form of a shape; ellipsoids and cylinders are smooth, meshes must be convex.
/// @param unit_m  of length
/// @param body    for the error
/// @param kept    owns it and its parts
/// @throws CaseError naming the body if a mesh is concave
btCollisionShape* bullet_shape(const Shape& shape, double unit_m, const std::string& body, BulletShapes& kept) {
  switch (shape.kind) {
    case ShapeKind::sphere:
      return keep(std::make_unique<btSphereShape>(shape.radius_m / unit_m), kept);
    case ShapeKind::capsule:
      return keep(std::make_unique<btCapsuleShapeZ>(shape.radius_m / unit_m, shape.length_m / unit_m), kept);
    case ShapeKind::ellipsoid:
    case ShapeKind::cylinder:
      return keep(std::make_unique<ConvexSolid>(make_solid(shape, unit_m)), kept);
    case ShapeKind::box: {
      auto* const made = keep(std::make_unique<btBoxShape>(to_bullet(0.5 / unit_m * shape.extents_m)), kept);
      made->setMargin(0.0);
      made->initializePolyhedralFeatures();
      return made;
    }
    case ShapeKind::mesh:
      return hull_of(shape, unit_m, body, kept);
    case ShapeKind::compound:
      break;
  }
  auto* const whole = keep(std::make_unique<btCompoundShape>(), kept);
  for (const auto& [part, position_m, q] : shape.parts)
    whole->addChildShape(btTransform({q[1], q[2], q[3], q[0]}, to_bullet(position_m / unit_m)),
                         bullet_shape(part, unit_m, body, kept));
  return whole;
}

/// Bullet's contact of a convex shape with a plane, which is at its deepest point, and further ones around: what falls
/// flat meets the plane with all of its side. Of a capsule the other one is at the other end.
class ShapeOnPlane final : public btConvexPlaneCollisionAlgorithm {
 public:
  using btConvexPlaneCollisionAlgorithm::btConvexPlaneCollisionAlgorithm;

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    btConvexPlaneCollisionAlgorithm::processCollision(first, second, info, result);
    const btPersistentManifold* const deepest = result->getPersistentManifold();
    if (deepest == nullptr || deepest->getNumContacts() == 0) return;
    if (first->getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE) std::swap(first, second);
    const auto& shape = static_cast<const btConvexShape&>(*first->getCollisionShape());
    const auto& plane = static_cast<const btStaticPlaneShape&>(*second->getCollisionShape());
    const btTransform& pose = first->getWorldTransform();
    const btVector3& normal = plane.getPlaneNormal();  // walls are not turned
    const auto add = [&](const btVector3& point, btScalar radius) {
      const btScalar height = normal.dot(point) - plane.getPlaneConstant();
      result->addContactPoint(normal, point - height * normal, height - radius);
    };
    if (shape.getShapeType() == CAPSULE_SHAPE_PROXYTYPE) {
      const auto& capsule = static_cast<const btCapsuleShape&>(shape);
      btVector3 end = capsule.getHalfHeight() * pose.getBasis().getColumn(2);
      const btManifoldPoint& own = deepest->getContactPoint(deepest->getNumContacts() - 1);
      if (end.dot(own.getPositionWorldOnB() - pose.getOrigin()) > 0.0) end = -end;
      return add(pose.getOrigin() + end, capsule.getRadius());
    }
    constexpr int directions = 8;
    constexpr btScalar slope = 0.1;
    btVector3 one, other;
    btPlaneSpace1(normal, one, other);
    for (int i = 0; i < directions; ++i) {
      const btScalar angle_rad = 2.0 * std::numbers::pi * i / directions;
      const btVector3 sideways = slope * (std::cos(angle_rad) * one + std::sin(angle_rad) * other);
      add(pose * shape.localGetSupportingVertex((sideways - normal) * pose.getBasis()), 0.0);
    }
  }

  struct CreateFunc final : btConvexPlaneCollisionAlgorithm::CreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
      void* const place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(ShapeOnPlane));
      return new (place) ShapeOnPlane(nullptr, info, first, second, m_swapped, 1, 0);
    }
  };
};

constexpr int solver_iterations = 50;  // of projected Gauss-Seidel, at most

/// The pools of contacts that Bullet sets aside; more are allocated one by one.
btDefaultCollisionConstructionInfo small_pools() {
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = 64;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 64;
  return info;
}

Eigen::Vector3d from_bullet(const btVector3& vector, double unit) {
  return {vector.x() * unit, vector.y() * unit, vector.z() * unit};
}

btQuaternion to_bullet_rotation(const Eigen::Vector4d& q) { return {q[1], q[2], q[3], q[0]}; }

/// A frame whose x axis is `axis`, in the world.
btMatrix3x3 frame_along(const Eigen::Vector3d& axis) {
  Eigen::Vector3d second = axis.unitOrthogonal();
  const Eigen::Vector3d third = axis.cross(second);
  return {axis[0], second[0], third[0], axis[1], second[1], third[1], axis[2], second[2], third[2]};
}

/// The root of that between bodies. Where only walls have friction, so little that it does not count between bodies,
/// but its product with that of a wall does.
double friction_of_a_body(const BodySetup& setup) {
  const bool only_walls = setup.contact.friction == 0.0 &&
                          std::ranges::any_of(setup.walls, [](const auto& wall) { return wall.friction > 0.0; });
  return only_walls ? 1e-6 : std::sqrt(setup.contact.friction);
}

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

class BulletWorld final : public EngineWorld {
 public:
  BulletWorld(const BodySetup& setup, const BodyModel& model, double step_s)
      : model_(model),
        units_(engine_units(model, step_s)),
        contact_(setup.contact),
        friction_of_a_body_(friction_of_a_body(setup)),
        configuration_(small_pools()),
        dispatcher_(&configuration_),
        springs_(setup) {
    // Bullet forgets a contact whose points rounding has moved apart by more than this [radii].
    if (is_resolving(contact_)) gContactBreakingThreshold = 1e-9;
    plane_and_shape_.m_swapped = true;
    for (const int kind :
         {CAPSULE_SHAPE_PROXYTYPE, BOX_SHAPE_PROXYTYPE, CONVEX_HULL_SHAPE_PROXYTYPE, CUSTOM_CONVEX_SHAPE_TYPE}) {
      dispatcher_.registerCollisionCreateFunc(kind, STATIC_PLANE_PROXYTYPE, &shape_and_plane_);
      dispatcher_.registerCollisionCreateFunc(STATIC_PLANE_PROXYTYPE, kind, &plane_and_shape_);
    }
    const Kinematics start = initial_kinematics(model);
    for (Eigen::Index body = 0; body < model.bodies(); ++body) {
      add_body(body, setup.bodies[body]);
      place(body, start);
      if (model.motion(body) == MotionKind::axis) add_joint(body, start);
    }
    for (const WallSpecification& wall : setup.walls) add_wall(wall);
    for (const SpringSpecification& spring : setup.springs)
      pulls_.push_back(std::make_unique<SpringConstraint>(*bodies_[spring.body_A], *bodies_[spring.body_B]));
  }

  [[nodiscard]] bool has_springs() const override { return true; }

  /// One step of semi-implicit Euler with constraints, v' = v + h F/m, x' = x + h v'.
  void advance(Kinematics& state, const Loads& loads) override {
    btDbvtBroadphase broadphase;
    btSequentialImpulseConstraintSolver solver;
    btDiscreteDynamicsWorld world(&dispatcher_, &broadphase, &solver, &configuration_);
    configure(world, loads);
    for (Eigen::Index body = 0; body < std::ssize(bodies_); ++body) {
      place(body, state);
      bodies_[body]->applyCentralForce(to_bullet(loads.force_N.col(body), units_.force_N()));
      bodies_[body]->applyTorque(to_bullet(loads.torque_N_m.col(body), units_.torque_N_m()));
      world.addRigidBody(bodies_[body].get());
    }
    for (const auto& wall : walls_) world.addRigidBody(wall.get());
    const auto motion = as_motion_state<BlockState>(state);
    const BlockVectors angular_velocity_rad_per_s = state.angular_velocity_rad_per_s;
    for (std::size_t i = 0; i < pulls_.size(); ++i) {
      const Springs::Pull pull = springs_.pull(i, 0, motion, angular_velocity_rad_per_s);
      const Eigen::Vector3d direction = pull.d_AB_W_m.normalized();
      pulls_[i]->set_pull(pull.f_A_W_N.dot(direction) / units_.force_N(), to_bullet(direction),
                          to_bullet(pull.r_A_W_m, units_.length_m), to_bullet(pull.r_B_W_m, units_.length_m));
      world.addConstraint(pulls_[i].get());
    }
    for (const auto& joint : joints_) world.addConstraint(joint.get());
    world.stepSimulation(1.0, 0);  // one step of one unit of time
    for (Eigen::Index body = 0; body < model_.bodies(); ++body) read(body, state);
  }

 private:
  void add_body(Eigen::Index body, const BodySpecification& specification) {
    btCollisionShape* shape = bullet_shape(specification.shape, units_.length_m, specification.name, shapes_);
    const bool moves = model_.moves(body);
    const double mass_kg = 1.0 / model_.inverse_mass_per_kg(body);
    const Eigen::Matrix3d tensor = inertia_tensor_kg_m2(specification);
    Eigen::Vector3d inertia = tensor.diagonal();
    q_BP_.push_back(btQuaternion::getIdentity());
    if (!tensor.isDiagonal(0.0)) {
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(tensor);
      inertia = principal.eigenvalues();
      Eigen::Matrix3d axes = principal.eigenvectors();
      axes.col(2) = axes.col(0).cross(axes.col(1));
      const Eigen::Quaterniond q(axes);
      q_BP_.back() = {q.x(), q.y(), q.z(), q.w()};
      auto turned = std::make_unique<btCompoundShape>();
      turned->addChildShape(btTransform(q_BP_.back().inverse()), shape);
      shape = turned.get();
      shapes_.push_back(std::move(turned));
    }
    btRigidBody::btRigidBodyConstructionInfo info(moves ? mass_kg / units_.mass_kg : 0.0, nullptr, shape,
                                                  to_bullet(inertia, units_.inertia_kg_m2()));
    btRigidBody& made = *bodies_.emplace_back(std::make_unique<btRigidBody>(info));
    give_contact_properties(made, friction_of_a_body_);
    made.setActivationState(DISABLE_DEACTIVATION);
    if (!moves) made.setCollisionFlags(made.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
  }

  /// Bullet multiplies those of two bodies.
  void give_contact_properties(btRigidBody& body, double friction) const {
    body.setRestitution(is_resolving(contact_) ? std::sqrt(contact_.restitution) : 0.0);
    body.setFriction(is_resolving(contact_) ? friction : 0.0);
  }

  void add_wall(const WallSpecification& wall) {
    require_at_rest(wall);
    shapes_.push_back(
        std::make_unique<btStaticPlaneShape>(to_bullet(wall.normal), wall.normal.dot(wall.point_m) / units_.length_m));
    walls_.push_back(
        std::make_unique<btRigidBody>(btRigidBody::btRigidBodyConstructionInfo(0.0, nullptr, shapes_.back().get())));
    give_contact_properties(*walls_.back(), wall.friction > 0.0 ? wall.friction / friction_of_a_body_ : 0.0);
  }

  void add_joint(Eigen::Index body, const Kinematics& start) {
    btRigidBody& moving = *bodies_[body];
    const btTransform rail(frame_along(model_.axis(body)), to_bullet(start.position_m.col(body), units_.length_m));
    const btTransform on_body = moving.getWorldTransform().inverse() * rail;
    auto joint =
        std::make_unique<btGeneric6DofSpring2Constraint>(btTypedConstraint::getFixedBody(), moving, rail, on_body);
    constexpr int along = 0, about = 3;
    for (int freedom = 0; freedom < 6; ++freedom) {
      const bool free = freedom == along || freedom == about;
      joint->setLimit(freedom, free ? 1.0 : 0.0, free ? -1.0 : 0.0);  // a lower limit above the upper one is none
    }
    joints_.push_back(std::move(joint));
  }

  void place(Eigen::Index body, const Kinematics& state) {
    btRigidBody& placed = *bodies_[body];
    const btTransform pose(to_bullet_rotation(state.orientation_wxyz.col(body)) * q_BP_[body],
                           to_bullet(state.position_m.col(body), units_.length_m));
    const btVector3 velocity = to_bullet(state.velocity_m_per_s.col(body), units_.velocity_m_per_s());
    const btVector3 angular_velocity = to_bullet(state.angular_velocity_rad_per_s.col(body), 1.0 / units_.time_s);
    placed.setWorldTransform(pose);
    placed.setLinearVelocity(velocity);
    placed.setAngularVelocity(angular_velocity);
    // Bullet derives the velocity of a kinematic body from its interpolated (previous) pose.
    btTransform last;
    btTransformUtil::integrateTransform(pose, -velocity, -angular_velocity, 1.0, last);
    placed.setInterpolationWorldTransform(last);
    placed.updateInertiaTensor();
    placed.clearForces();
  }

  /// With `contact` in the case the solver acts once surfaces overlap, changes velocities by the restitution only, and
  /// moves bodies apart without a velocity; what lies does not rebound from what its weight gains in a step.
  void configure(btDiscreteDynamicsWorld& world, const Loads& loads) const {
    world.setGravity({0, 0, 0});  // weight comes with the other forces
    auto& info = world.getSolverInfo();
    info.m_numIterations = solver_iterations;
    info.m_solverMode &= ~SOLVER_USE_WARMSTARTING;
    world.getDispatchInfo().m_deterministicOverlappingPairs = true;
    if (!is_resolving(contact_)) return;
    info.m_erp2 = 0.0;
    info.m_splitImpulsePenetrationThreshold = 0.0;
    info.m_restitutionVelocityThreshold = 0.0;
    for (Eigen::Index body = 0; body < model_.bodies(); ++body) {
      const double gained = loads.force_N.col(body).norm() * model_.inverse_mass_per_kg(body) * units_.time_s;
      info.m_restitutionVelocityThreshold =
          std::max(info.m_restitutionVelocityThreshold, 4.0 * gained / units_.velocity_m_per_s());
    }
  }

  void read(Eigen::Index body, Kinematics& state) const {
    auto q = state.orientation_wxyz.col(body);
    auto x = state.position_m.col(body);
    if (!model_.moves(body)) {  // keeps its velocities; Bullet does not move it
      x += units_.time_s * state.velocity_m_per_s.col(body);
      q = rotated(units_.time_s * state.angular_velocity_rad_per_s.col(body), q).normalized();
      return;
    }
    const btRigidBody& moved = *bodies_[body];
    x = from_bullet(moved.getWorldTransform().getOrigin(), units_.length_m);
    state.velocity_m_per_s.col(body) = from_bullet(moved.getLinearVelocity(), units_.velocity_m_per_s());
    state.angular_velocity_rad_per_s.col(body) = from_bullet(moved.getAngularVelocity(), 1.0 / units_.time_s);
    const btQuaternion turned = moved.getWorldTransform().getRotation() * q_BP_[body].inverse();
    q = of_the_same_sign({turned.w(), turned.x(), turned.y(), turned.z()}, q);
  }

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

}  // namespace

std::unique_ptr<EngineWorld> make_bullet_world(const BodySetup& setup, const BodyModel& model, double step_s) {
  return std::make_unique<BulletWorld>(setup, model, step_s);
}

}  // namespace copepod::body
