#pragma once

#include <BulletCollision/CollisionDispatch/btConvexPlaneCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <memory>
#include <new>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "contract/shape.hpp"

namespace copepod::body {

using BulletShapes = std::vector<std::unique_ptr<btCollisionShape>>;

/// Bullet's form of a shape; ellipsoids and cylinders are smooth, meshes must be convex.
/// @param unit_m  of length
/// @param body    for the error
/// @param kept    owns it and its parts
/// @throws CaseError naming the body if a mesh is concave
btCollisionShape* bullet_shape(const Shape& shape, double unit_m, const std::string& body, BulletShapes& kept);

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
      add(pose.getOrigin() + end, capsule.getRadius());
      return;
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

}  // namespace copepod::body
