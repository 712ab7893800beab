#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "geometry/shapes/solid.hpp"

namespace copepod {

namespace {

/// Inside a closed surface of triangles: an odd number of them lies between a point and infinity.
class MeshSolid final : public Solid {
 public:
  explicit MeshSolid(TriangleMesh mesh) : mesh_(std::move(mesh)) {}

  [[nodiscard]] double bounding_radius() const override { return mesh_.bounding_radius_m; }
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const override {
    Eigen::Index farthest = 0;
    (direction.transpose() * mesh_.vertices_m).maxCoeff(&farthest);
    return mesh_.vertices_m.col(farthest);
  }

  /// In a frame whose third axis is the line: a triangle is crossed where the origin lies in its projection. An edge
  /// is on the same side of the origin for both of its triangles, so that no line slips through between two.
  void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const override {
    Eigen::Matrix3d frame;
    frame.row(2) = direction.normalized();
    frame.row(0) = Eigen::Vector3d(frame.row(2)).unitOrthogonal();
    frame.row(1) = Eigen::Vector3d(frame.row(2)).cross(Eigen::Vector3d(frame.row(0)));
    const Eigen::Matrix3Xd seen = frame * (mesh_.vertices_m.colwise() - origin);
    // Twice the area between the origin and an edge, with the sign of its turn.
    const auto turn = [&](int a, int b) { return seen(0, a) * seen(1, b) - seen(1, a) * seen(0, b); };
    const auto is_left = [&](int a, int b) { return a < b ? turn(a, b) > 0.0 : !(turn(b, a) > 0.0); };
    std::vector<double> at;
    for (const auto& corners : mesh_.triangles.colwise()) {
      const bool left = is_left(corners[0], corners[1]);
      if (is_left(corners[1], corners[2]) != left || is_left(corners[2], corners[0]) != left) continue;
      const Eigen::Vector3d weights(turn(corners[1], corners[2]), turn(corners[2], corners[0]),
                                    turn(corners[0], corners[1]));
      const double area = weights.sum();
      const Eigen::Vector3d heights(seen(2, corners[0]), seen(2, corners[1]), seen(2, corners[2]));
      if (area != 0.0) at.push_back(weights.dot(heights) / area / direction.norm());
    }
    std::ranges::sort(at);
    inside.clear();
    for (std::size_t i = 0; i + 1 < at.size(); i += 2) inside.push_back({at[i], at[i + 1]});
    unite(inside);
  }

  [[nodiscard]] VolumeMoments moments() const override { return moments_by_surface(mesh_); }

  /// Each triangle with corners of its own: edges stay sharp.
  [[nodiscard]] Surface surface(int /*around*/) const override {
    const Eigen::Index count = mesh_.triangles.cols();
    Surface surface{Eigen::Matrix3Xd(3, 3 * count), Eigen::Matrix3Xd(3, 3 * count), {}};
    for (Eigen::Index t = 0; t < count; ++t) {
      for (int corner = 0; corner < 3; ++corner)
        surface.points.col(3 * t + corner) = mesh_.vertices_m.col(mesh_.triangles(corner, t));
      const auto first = static_cast<std::int32_t>(3 * t);
      surface.join({first, first + 1, first + 2});
      const auto corners = surface.points.middleCols<3>(3 * t);
      const Eigen::Vector3d normal =
          Eigen::Vector3d(corners.col(1) - corners.col(0)).cross(Eigen::Vector3d(corners.col(2) - corners.col(0)));
      surface.normals.middleCols<3>(3 * t).colwise() = normal.stableNormalized();
    }
    return surface;
  }

 private:
  TriangleMesh mesh_;
};

}  // namespace

std::unique_ptr<Solid> make_mesh_solid(TriangleMesh mesh) { return std::make_unique<MeshSolid>(std::move(mesh)); }

TriangleMesh box_mesh(const Eigen::Vector3d& edges) {
  Eigen::Matrix3Xd vertices(3, 8);
  for (int i = 0; i < 8; ++i)
    for (int axis = 0; axis < 3; ++axis)
      vertices(axis, i) = ((i >> axis) & 1) != 0 ? 0.5 * edges[axis] : -0.5 * edges[axis];
  TriangleMesh::Triangles triangles(3, 12);
  triangles << 0, 0, 4, 4, 0, 0, 2, 2, 0, 0, 1, 1,  //
      2, 3, 5, 7, 1, 5, 6, 7, 4, 6, 3, 7,           //
      3, 1, 7, 6, 5, 4, 7, 3, 6, 2, 7, 5;
  return {std::move(vertices), std::move(triangles)};
}

/// Over the tetrahedra of the origin and each triangle, of signed volume v = a·(b × c)/6:
///   ∫ dV = v,   ∫ x dV = v/4 (a + b + c),   ∫ x xᵀ dV = v/20 (a aᵀ + b bᵀ + c cᵀ + s sᵀ),   s = a + b + c
VolumeMoments moments_by_surface(const TriangleMesh& mesh) {
  VolumeMoments sum;
  for (const auto& corners : mesh.triangles.colwise()) {
    Eigen::Matrix3d points;
    for (int i = 0; i < 3; ++i) points.col(i) = mesh.vertices_m.col(corners[i]);
    const double volume = points.determinant() / 6.0;
    const Eigen::Vector3d total = points.rowwise().sum();
    sum += {volume, volume / 4.0 * total, volume / 20.0 * (points * points.transpose() + total * total.transpose())};
  }
  return sum;
}

}  // namespace copepod
