#include <algorithm>

#include <Eigen/Geometry>

#include "geometry/shapes/solid.hpp"

namespace copepod {

namespace {

struct Crossing {
  double at = 0.0;
  int turn = 0;  ///< 1 where the line enters a surface whose front is outwards, −1 where it leaves it
};

/// Where the line along z through a place (x, y) crosses a triangle. An edge is on the same side of the place for both
/// of its triangles, so that no line slips through between two.
template <class Corners>
std::optional<Crossing> crossing(const Eigen::Matrix3Xd& vertices, const Corners& corners,
                                 const Eigen::Vector2d& place) {
  // Twice the area between the place and an edge, with the sign of its turn.
  const auto area = [&](int a, int b) {
    return (vertices(0, a) - place[0]) * (vertices(1, b) - place[1]) -
           (vertices(1, a) - place[1]) * (vertices(0, b) - place[0]);
  };
  const auto is_left = [&](int a, int b) { return a < b ? area(a, b) > 0.0 : !(area(b, a) > 0.0); };
  const bool left = is_left(corners[0], corners[1]);
  if (is_left(corners[1], corners[2]) != left || is_left(corners[2], corners[0]) != left) return {};
  const Eigen::Vector3d weights(area(corners[1], corners[2]), area(corners[2], corners[0]),
                                area(corners[0], corners[1]));
  if (weights.sum() == 0.0) return {};
  const Eigen::Vector3d heights(vertices(2, corners[0]), vertices(2, corners[1]), vertices(2, corners[2]));
  return Crossing{weights.dot(heights) / weights.sum(), left ? -1 : 1};
}

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

  /// In a frame whose third axis is the line.
  void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const override {
    Eigen::Matrix3d frame;
    frame.row(2) = direction.normalized();
    frame.row(0) = Eigen::Vector3d(frame.row(2)).unitOrthogonal();
    frame.row(1) = Eigen::Vector3d(frame.row(2)).cross(Eigen::Vector3d(frame.row(0)));
    const Eigen::Matrix3Xd seen = frame * (mesh_.vertices_m.colwise() - origin);
    std::vector<double> at;
    for (const auto& corners : mesh_.triangles.colwise())
      if (const auto found = crossing(seen, corners, Eigen::Vector2d::Zero()))
        at.push_back(found->at / direction.norm());
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

std::optional<Eigen::Vector3d> enclosed_twice(const TriangleMesh& mesh) {
  constexpr int lines = 256;
  const Eigen::Matrix3d frame = oblique_frame();
  const Eigen::Matrix3Xd seen = frame.transpose() * mesh.vertices_m;
  const Eigen::Vector2d low = seen.topRows<2>().rowwise().minCoeff();
  const Eigen::Vector2d width = (seen.topRows<2>().rowwise().maxCoeff() - low) / lines;
  const auto place = [&](int i, int j) -> Eigen::Vector2d {
    return low + width.cwiseProduct(Eigen::Vector2d(i + 0.5, j + 0.5));
  };
  std::vector<std::vector<Crossing>> found(std::size_t{lines} * lines);
  for (const auto& corners : mesh.triangles.colwise()) {
    Eigen::Matrix<double, 2, 3> flat;
    for (int corner = 0; corner < 3; ++corner) flat.col(corner) = seen.col(corners[corner]).head<2>();
    const Eigen::Array2i first = ((flat.rowwise().minCoeff() - low).array() / width.array() - 0.5).ceil().cast<int>();
    const Eigen::Array2i last = ((flat.rowwise().maxCoeff() - low).array() / width.array() - 0.5).floor().cast<int>();
    for (int i = std::max(first[0], 0); i <= std::min(last[0], lines - 1); ++i)
      for (int j = std::max(first[1], 0); j <= std::min(last[1], lines - 1); ++j)
        if (const auto next = crossing(seen, corners, place(i, j))) found[std::size_t(lines) * i + j].push_back(*next);
  }
  const double rounding = 1e-9 * mesh.bounding_radius_m;
  for (int i = 0; i < lines; ++i)
    for (int j = 0; j < lines; ++j) {
      auto& line = found[std::size_t(lines) * i + j];
      std::ranges::sort(line, {}, &Crossing::at);
      int enclosed = 0;
      for (std::size_t k = 0; k + 1 < line.size(); ++k) {
        enclosed += line[k].turn;
        if (enclosed == 0 || enclosed == 1 || line[k + 1].at - line[k].at < rounding) continue;
        const Eigen::Vector2d at = place(i, j);
        return frame * Eigen::Vector3d(at[0], at[1], 0.5 * (line[k].at + line[k + 1].at));
      }
    }
  return {};
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
