#include "bullet/bullet_shapes.hpp"

#include <LinearMath/btConvexHullComputer.h>
#include <utility>

#include "contract/errors.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::body {

namespace {

btVector3 to_bullet(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

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

}  // namespace

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

}  // namespace copepod::body
