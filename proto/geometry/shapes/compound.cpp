#include <algorithm>

#include "geometry/rotation.hpp"
#include "geometry/shapes/solid.hpp"

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

std::unique_ptr<Solid> make_compound(const std::vector<ShapePart>& parts, double unit_m) {
  return std::make_unique<Compound>(parts, unit_m);
}

}  // namespace copepod
