#include "geometry/shapes/overlaps.hpp"

#include <algorithm>
#include <limits>
#include <map>
#include <utility>

#include "geometry/rotation.hpp"

namespace copepod {

/// A solid somewhere.
struct Overlaps::Placed {
  const Solid& solid;
  Eigen::Vector3d position_m;
  Eigen::Matrix3d R;

  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const {
    return position_m + R * solid.support(R.transpose() * direction);
  }
};

namespace {

/// Whether a plane between the convex hulls of two solids is found: the nearest point v to the origin of all
/// differences of their points is approached from above [Gilbert 1966].
bool are_apart(const auto& A, const auto& B) {
  constexpr int most_tries = 30;
  Eigen::Vector3d v = A.position_m - B.position_m;
  for (int tries = 0; tries < most_tries && !v.isZero(0.0); ++tries) {
    const Eigen::Vector3d w = A.support(-v) - B.support(v);
    if (v.dot(w) >= 0.0) return true;
    const Eigen::Vector3d step = w - v;
    v -= std::min(1.0, v.dot(step) / step.squaredNorm()) * step;
  }
  return false;
}

/// The least way out of a solid along the axes of its frame.
double way_out_m(const Solid& solid, const Eigen::Vector3d& point_m, Intervals& inside) {
  double least_m = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    solid.crossings(point_m, Eigen::Vector3d::Unit(axis), inside);
    const auto around = std::ranges::find_if(inside, [](const Interval& part) { return part.high > 0.0; });
    if (around == inside.end()) return 0.0;
    least_m = std::min({least_m, -around->low, around->high});
  }
  return least_m;
}

/// How deep edges on the surface of one solid are inside another.
double depth_of_edges_m(const auto& one, const auto& other) {
  constexpr int around = 64;
  const Surface surface = one.solid.surface(around);
  const Eigen::Matrix3Xd points_m =
      other.R.transpose() * ((one.R * surface.points).colwise() + (one.position_m - other.position_m));
  const double reach_m = other.solid.bounding_radius();
  const double negligible_m = 1e-9 * reach_m;
  double deepest_m = 0.0;
  Intervals inside;
  const auto follow = [&](const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m) {
    const Eigen::Vector3d edge_m = to_m - from_m;
    const double nearest = std::clamp(-from_m.dot(edge_m) / edge_m.squaredNorm(), 0.0, 1.0);
    if ((from_m + nearest * edge_m).norm() >= reach_m) return;
    other.solid.crossings(from_m, edge_m, inside);
    Intervals on_way;
    for (const Interval& part : inside) {
      const double middle = 0.5 * (std::max(part.low, 0.0) + std::min(part.high, 1.0));
      if (part.low < middle && middle < part.high)
        deepest_m = std::max(deepest_m, way_out_m(other.solid, from_m + middle * edge_m, on_way));
    }
  };
  surface.for_each_triangle([&](std::int32_t a, std::int32_t b, std::int32_t c) {
    for (const auto& [from, to] : {std::pair{a, b}, {b, c}, {c, a}}) follow(points_m.col(from), points_m.col(to));
  });
  return deepest_m > negligible_m ? deepest_m : 0.0;
}

}  // namespace

Overlaps::Overlaps(std::vector<Shape> shapes, const PeriodicImages& images)
    : shapes_(std::move(shapes)), images_(images) {
  if (std::ranges::all_of(shapes_, is_round)) return;
  std::map<const TriangleMesh*, std::shared_ptr<const Solid>> of_mesh;  // swarms share one
  for (const Shape& shape : shapes_) {
    auto& solid = solids_.emplace_back(shape.mesh == nullptr ? nullptr : of_mesh[shape.mesh.get()]);
    if (solid == nullptr) solid = make_solid(shape);
    if (shape.mesh != nullptr) of_mesh[shape.mesh.get()] = solid;
  }
}

template <class Depth>
double Overlaps::deepest_m(int A, int B, const Eigen::Matrix3Xd& position_m, const Eigen::Matrix4Xd& orientation_wxyz,
                           const Depth& depth) const {
  const auto placed = [&](int body, const Eigen::Vector3d& place_m) {
    return Placed{*solids_[body], place_m, rotation_matrix(orientation_wxyz.col(body))};
  };
  const double reach_m = bounding_radius_m(shapes_[A]) + bounding_radius_m(shapes_[B]);
  double deepest_m = 0.0;
  images_.for_each(position_m.col(B) - position_m.col(A), reach_m,
                   [&](const Eigen::Vector3d& place_m, const Eigen::Vector3d& number) {
                     if (A == B && number.isZero(0.0)) return;
                     deepest_m = std::max(deepest_m, depth(placed(A, Eigen::Vector3d::Zero()), placed(B, place_m)));
                   });
  return deepest_m;
}

double Overlaps::depth_m(int A, int B, const Eigen::Matrix3Xd& position_m,
                         const Eigen::Matrix4Xd& orientation_wxyz) const {
  const Shape& first = shapes_[A];
  const Shape& second = shapes_[B];
  if (is_round(first) && is_round(second)) {
    const double reach_m = bounding_radius_m(first) + bounding_radius_m(second);
    const double distance_m =
        images_.smallest_distance_m(core_of(first, A, position_m, orientation_wxyz),
                                    core_of(second, B, position_m, orientation_wxyz), reach_m, A == B);
    return -(distance_m - first.radius_m - second.radius_m);
  }
  return deepest_m(A, B, position_m, orientation_wxyz, [](const Placed& one, const Placed& other) {
    return are_apart(one, other) ? 0.0 : std::max(depth_of_edges_m(one, other), depth_of_edges_m(other, one));
  });
}

double Overlaps::depth_inside_m(int A, int B, const Eigen::Matrix3Xd& position_m,
                                const Eigen::Matrix4Xd& orientation_wxyz) const {
  if (solids_.empty()) return depth_m(A, B, position_m, orientation_wxyz);
  return deepest_m(A, B, position_m, orientation_wxyz,
                   [](const Placed& one, const Placed& other) { return depth_of_edges_m(one, other); });
}

}  // namespace copepod
