#include "geometry/shapes/solid.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

#include <Eigen/Geometry>

#include "geometry/rotation.hpp"

namespace copepod {

namespace {

/// The union of parts.
class Compound final : public Solid {
 public:
  Compound(const std::vector<ShapePart>& parts, double unit_m) {
    for (const ShapePart& part : parts)
      parts_.push_back({make_solid(part.shape, unit_m), part.position_m / unit_m,
                        rotation_matrix(part.orientation_wxyz.normalized())});
  }

  [[nodiscard]] double bounding_radius() const override {
    double radius = 0.0;
    for (const Part& part : parts_) radius = std::max(radius, part.position.norm() + part.solid->bounding_radius());
    return radius;
  }
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const override {
    Eigen::Vector3d farthest = Eigen::Vector3d::Zero();
    double distance = -std::numeric_limits<double>::infinity();
    for (const auto& [solid, position, R] : parts_) {
      const Eigen::Vector3d point = position + R * solid->support(R.transpose() * direction);
      if (point.dot(direction) > distance) distance = point.dot(direction), farthest = point;
    }
    return farthest;
  }
  void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const override {
    inside.clear();
    Intervals of_part;
    for (const auto& [solid, position, R] : parts_) {
      solid->crossings(R.transpose() * (origin - position), R.transpose() * direction, of_part);
      inside.insert(inside.end(), of_part.begin(), of_part.end());
    }
    unite(inside);
  }
  /// The sum over the parts, or by lines where they overlap.
  [[nodiscard]] VolumeMoments moments() const override {
    VolumeMoments sum;
    for (const auto& [solid, position, R] : parts_) sum += solid->moments().moved(R, position);
    return parts_overlap() ? moments_by_lines(*this) : sum;
  }
  [[nodiscard]] Surface surface(int around) const override {
    Surface all;
    for (const auto& [solid, position, R] : parts_) {
      Surface part = solid->surface(around);
      const Eigen::Index points = all.points.cols();
      all.points.conservativeResize(3, points + part.points.cols());
      all.normals.conservativeResize(3, points + part.points.cols());
      all.points.rightCols(part.points.cols()) = (R * part.points).colwise() + position;
      all.normals.rightCols(part.points.cols()) = R * part.normals;
      for (std::int32_t& point : part.strip) point += static_cast<std::int32_t>(points);
      all.join(part.strip);
    }
    return all;
  }

 private:
  struct Part {
    std::unique_ptr<Solid> solid;
    Eigen::Vector3d position;
    Eigen::Matrix3d R;
  };

  /// Whether a point on the surface of a part lies inside another, or two parts are the same.
  [[nodiscard]] bool parts_overlap() const {
    constexpr int around = 32;
    for (const Part& one : parts_) {
      const Eigen::Matrix3Xd points = (one.R * one.solid->surface(around).points).colwise() + one.position;
      for (const Part& other : parts_) {
        if (&one == &other) continue;
        const double reach = other.solid->bounding_radius();
        const auto is_inside = [&](const Eigen::Vector3d& point) {
          return (point - other.position).norm() < reach &&
                 other.solid->contains(other.R.transpose() * (point - other.position));
        };
        if (is_inside(one.position)) return true;
        for (const auto& point : points.colwise())
          if (is_inside(point)) return true;
      }
    }
    return false;
  }

  std::vector<Part> parts_;
};

}  // namespace

void unite(Intervals& intervals) {
  std::ranges::sort(intervals, {}, &Interval::low);
  std::size_t kept = 0;
  for (const Interval& next : intervals) {
    if (kept > 0 && next.low <= intervals[kept - 1].high)
      intervals[kept - 1].high = std::max(intervals[kept - 1].high, next.high);
    else
      intervals[kept++] = next;
  }
  intervals.resize(kept);
}

VolumeMoments VolumeMoments::moved(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) const {
  const Eigen::Vector3d turned = R * first;
  return {volume, turned + volume * t,
          R * second * R.transpose() + turned * t.transpose() + t * turned.transpose() + volume * t * t.transpose()};
}

VolumeMoments& VolumeMoments::operator+=(const VolumeMoments& other) {
  volume += other.volume;
  first += other.first;
  second += other.second;
  return *this;
}

void Surface::join(const std::vector<std::int32_t>& next) {
  if (!strip.empty()) {
    if (strip.size() % 2 != 0) strip.push_back(strip.back());
    strip.insert(strip.end(), {strip.back(), next.front()});
  }
  strip.insert(strip.end(), next.begin(), next.end());
}

bool Solid::contains(const Eigen::Vector3d& point) const {
  Intervals inside;
  crossings(point, Eigen::Vector3d::UnitZ(), inside);
  return std::ranges::any_of(inside, [](const Interval& part) { return part.low < 0.0 && part.high > 0.0; });
}

std::unique_ptr<Solid> make_solid(const Shape& shape, double unit_m) {
  switch (shape.kind) {
    case ShapeKind::sphere:
    case ShapeKind::capsule:
      return make_capsule(shape.radius_m / unit_m, 2.0 * core_half_length_m(shape) / unit_m);
    case ShapeKind::ellipsoid:
      return make_ellipsoid(shape.extents_m / unit_m);
    case ShapeKind::cylinder:
      return make_cylinder(shape.radius_m / unit_m, shape.length_m / unit_m);
    case ShapeKind::box:
      return make_mesh_solid(box_mesh(shape.extents_m / unit_m));
    case ShapeKind::mesh:
      return make_mesh_solid({shape.mesh->vertices_m / unit_m, shape.mesh->triangles});
    case ShapeKind::compound:
      return std::make_unique<Compound>(shape.parts, unit_m);
  }
  throw std::logic_error("a shape of no kind");
}

Eigen::Matrix3d oblique_frame() {
  Eigen::Matrix3d frame;
  frame.col(2) = Eigen::Vector3d(0.3, 0.5, 0.8).normalized();
  frame.col(0) = Eigen::Vector3d(0.9, -0.7, 0.1).cross(Eigen::Vector3d(frame.col(2))).normalized();
  frame.col(1) = Eigen::Vector3d(frame.col(2)).cross(Eigen::Vector3d(frame.col(0)));
  return frame;
}

VolumeMoments moments_by_lines(const Solid& solid) {
  constexpr int lines = 512;  // along each of two axes
  const Eigen::Matrix3d frame = oblique_frame();
  std::array<double, 2> low{};
  std::array<double, 2> width{};
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector3d along = frame.col(axis);
    low[axis] = along.dot(solid.support(-along));
    width[axis] = (along.dot(solid.support(along)) - low[axis]) / lines;
  }
  VolumeMoments sum;
  Intervals inside;
  for (int i = 0; i < lines; ++i)
    for (int j = 0; j < lines; ++j) {
      const Eigen::Vector3d from(low[0] + (i + 0.5) * width[0], low[1] + (j + 0.5) * width[1], 0.0);
      solid.crossings(frame * from, frame.col(2), inside);
      for (const auto& [a, b] : inside) {
        const double volume = (b - a) * width[0] * width[1];
        const Eigen::Vector3d middle = from + 0.5 * (a + b) * Eigen::Vector3d::UnitZ();
        Eigen::Matrix3d second = volume * middle * middle.transpose();
        second.diagonal() +=
            volume / 12.0 * Eigen::Vector3d(width[0] * width[0], width[1] * width[1], (b - a) * (b - a));
        sum += {volume, volume * middle, second};
      }
    }
  return sum.moved(frame, Eigen::Vector3d::Zero());
}

}  // namespace copepod
