#pragma once

#include <BulletCollision/CollisionDispatch/btConvexPlaneCollisionAlgorithm.h>
#include <BulletCollision/CollisionDispatch/btManifoldResult.h>
#include <BulletCollision/CollisionShapes/btCapsuleShape.h>
#include <BulletCollision/CollisionShapes/btStaticPlaneShape.h>
#include <LinearMath/btConvexHullComputer.h>
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <memory>
#include <new>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "contract/errors.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::body {

using BulletShapes = std::vector<std::unique_ptr<btCollisionShape>>;

inline btVector3 to_bullet(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

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

inline double volume_of(const btConvexHullComputer& hull) {
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

inline btCollisionShape* hull_of(const Shape& shape, double unit_m, const std::string& body, BulletShapes& kept) {
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
inline btCollisionShape* bullet_shape(const Shape& shape, double unit_m, const std::string& body, BulletShapes& kept) {
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
