#pragma once

#include <BulletCollision/CollisionDispatch/btConvexPlaneCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <new>
#include <utility>

namespace copepod::body {

/// Bullet's contact of a capsule with a plane, which is at its deepest point, and another one at the other end: a
/// capsule that falls flat meets the plane with both.
class CapsuleOnPlane final : public btConvexPlaneCollisionAlgorithm {
 public:
  using btConvexPlaneCollisionAlgorithm::btConvexPlaneCollisionAlgorithm;

  void processCollision(const btCollisionObjectWrapper* first, const btCollisionObjectWrapper* second,
                        const btDispatcherInfo& info, btManifoldResult* result) override {
    btConvexPlaneCollisionAlgorithm::processCollision(first, second, info, result);
    const btPersistentManifold* const deepest = result->getPersistentManifold();
    if (deepest == nullptr || deepest->getNumContacts() != 1) return;
    if (first->getCollisionShape()->getShapeType() == STATIC_PLANE_PROXYTYPE) std::swap(first, second);
    const auto& capsule = static_cast<const btCapsuleShape&>(*first->getCollisionShape());
    const auto& plane = static_cast<const btStaticPlaneShape&>(*second->getCollisionShape());
    const btTransform& pose = first->getWorldTransform();
    btVector3 end = capsule.getHalfHeight() * pose.getBasis().getColumn(2);
    if (end.dot(deepest->getContactPoint(0).getPositionWorldOnB() - pose.getOrigin()) > 0.0) end = -end;
    const btVector3& normal = plane.getPlaneNormal();  // walls are not turned
    const btScalar height = normal.dot(pose.getOrigin() + end) - plane.getPlaneConstant();
    result->addContactPoint(normal, pose.getOrigin() + end - height * normal, height - capsule.getRadius());
  }

  struct CreateFunc final : btConvexPlaneCollisionAlgorithm::CreateFunc {
    btCollisionAlgorithm* CreateCollisionAlgorithm(btCollisionAlgorithmConstructionInfo& info,
                                                   const btCollisionObjectWrapper* first,
                                                   const btCollisionObjectWrapper* second) override {
      void* const place = info.m_dispatcher1->allocateCollisionAlgorithm(sizeof(CapsuleOnPlane));
      return new (place) CapsuleOnPlane(nullptr, info, first, second, m_swapped, 1, 0);
    }
  };
};

}  // namespace copepod::body
