#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace copepod {

using BodyPair = std::pair<int, int>;  ///< indices, the lower one first

/// Form of a body or obstacle.
enum class ShapeKind { sphere, capsule, ellipsoid, cylinder, box, mesh, compound };

/// A closed surface of triangles, which may be concave.
struct TriangleMesh {
  using Triangles = Eigen::Matrix<std::int32_t, 3, Eigen::Dynamic>;  ///< three vertices of each, by number

  Eigen::Matrix3Xd vertices_m;     ///< shape (3, vertices)
  Triangles triangles;             ///< their corners, counter-clockwise seen from outside
  double bounding_radius_m = 0.0;  ///< of the smallest ball around the origin that contains it

  TriangleMesh() = default;
  TriangleMesh(Eigen::Matrix3Xd vertices, Triangles corners)
      : vertices_m(std::move(vertices)),
        triangles(std::move(corners)),
        bounding_radius_m(vertices_m.cols() == 0 ? 0.0 : vertices_m.colwise().norm().maxCoeff()) {}  ///< from [m]

  bool operator==(const TriangleMesh& other) const {
    return vertices_m.cols() == other.vertices_m.cols() && triangles.cols() == other.triangles.cols() &&
           vertices_m == other.vertices_m && triangles == other.triangles;
  }  ///< whether all numbers are the same
};

/// Part of a compound, in the frame of the whole. `Any`: Shape, which has parts itself.
template <class Any>
struct PartOf {
  Any shape;                                             ///< any but a compound
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of the origin of its frame
  Eigen::Vector4d orientation_wxyz{1, 0, 0, 0};          ///< unit quaternion
};

/// Rigid shape in the body frame, whose origin is the centre of mass.
/// A capsule is a cylinder of `length_m` along the body's z axis, closed by two half spheres; a cylinder has flat ends;
/// a compound is the union of its parts. Ellipsoids and boxes have the axes of the frame.
struct Shape {
  ShapeKind kind = ShapeKind::sphere;  ///< its form
  double radius_m = 0.0;  ///< of sphere, capsule and cylinder; of others that of a sphere of the same volume
  double length_m = 0.0;  ///< of the cylinder, or the cylinder part; else 0
  Eigen::Vector3d extents_m = Eigen::Vector3d::Zero();  ///< semi-axes of an ellipsoid, edges of a box
  std::shared_ptr<const TriangleMesh> mesh = nullptr;   ///< of a mesh
  std::vector<PartOf<Shape>> parts = {};                ///< of a compound
};

using ShapePart = PartOf<Shape>;  ///< of a compound

/// Whether a shape is all points within `radius_m` of its core segment. Contacts of our own are those of such shapes.
inline bool is_round(const Shape& shape) { return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::capsule; }

/// Whether thin films between two shapes are known: of spheres and capsules, and of spheres and ellipsoids. A shape
/// that has one with its like has one with walls.
inline bool have_films(const Shape& A, const Shape& B) {
  const auto is_smooth = [](const Shape& shape) {
    return shape.kind == ShapeKind::sphere || shape.kind == ShapeKind::ellipsoid;
  };
  return (is_round(A) && is_round(B)) || (is_smooth(A) && is_smooth(B));
}

/// Whether it matters how the shape is turned.
inline bool has_orientation(const Shape& shape) { return shape.kind != ShapeKind::sphere; }

/// Half the length of the core segment of a sphere or capsule [m]; 0 for a sphere.
inline double core_half_length_m(const Shape& shape) {
  return shape.kind == ShapeKind::capsule ? 0.5 * shape.length_m : 0.0;
}

/// Radius of the smallest sphere around the centre of mass that contains the shape [m]; of a compound an upper bound.
double bounding_radius_m(const Shape& shape);

/// Volume of a sphere or capsule V = π r² l + 4/3 π r³; of others that of a sphere of their radius          (B1), (B3)
/// [theory_bodies.md]
double volume_m3(const Shape& shape);

/// Length of the way through the shape along the normal, of which a quarter of its surface has less; of a compound that
/// of its thinnest part. What has edges is thinner still beside them.
double thickness_m(const Shape& shape);

/// Inertia tensor about the origin of a uniformly filled shape [kg m²]. Of spheres and capsules, m_c and m_s the masses
/// of cylinder and half spheres:
///   I_zz = m_c r²/2 + 2/5 m_s r²                                                                 (B2), (B4)
///   I_xx = I_yy = m_c (l²/12 + r²/4) + m_s (2/5 r² + 3/8 l r + l²/4)                                   (B5)
/// @param mass_kg  positive
Eigen::Matrix3d inertia_tensor_kg_m2(const Shape& shape, double mass_kg);

}  // namespace copepod
