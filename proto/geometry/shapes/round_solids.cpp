#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/shapes/solid.hpp"

namespace copepod {

namespace {

/// Where a |p|² is below the radius squared on a line: roots of t² d·d + 2 t o·d + o·o − R² = 0.
/// @param line  of the directions that count
bool enters_ball(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double radius, Interval& inside) {
  const double square = d.squaredNorm();
  const double linear = o.dot(d);
  const double discriminant = linear * linear - square * (o.squaredNorm() - radius * radius);
  if (!(discriminant > 0.0)) return false;
  const double root = std::sqrt(discriminant);
  inside = {(-linear - root) / square, (-linear + root) / square};
  return true;
}

Eigen::Vector3d across(const Eigen::Vector3d& v) { return {v[0], v[1], 0.0}; }

/// Where a line is inside the cylinder of radius R around the z axis with |z| < h.
bool enters_cylinder(const Eigen::Vector3d& o, const Eigen::Vector3d& d, double radius, double half, Interval& inside) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double parallel = 1e-24 * d.squaredNorm();  // square of a sine that is zero but for rounding
  inside = {-infinity, infinity};
  if (across(d).squaredNorm() > parallel) {
    if (!enters_ball(across(o), across(d), radius, inside)) return false;
  } else if (across(o).squaredNorm() >= radius * radius) {
    return false;
  }
  if (d[2] * d[2] > parallel) {
    const auto [low, high] = std::minmax({(-half - o[2]) / d[2], (half - o[2]) / d[2]});
    inside = {std::max(inside.low, low), std::min(inside.high, high)};
  } else if (std::abs(o[2]) >= half) {
    return false;
  }
  return inside.low < inside.high;
}

/// A ring of points around the z axis, `center` on it; a pole is a ring of one point.
struct Ring {
  Eigen::Vector2d point;   ///< (x, z) from the centre
  Eigen::Vector2d normal;  ///< (x, z)
  double center = 0.0;
};

/// Bands of triangles between rings, from the upper pole to the lower one. Triangles without area join them.
Surface surface_of_rings(const std::vector<Ring>& rings, int around) {
  const auto points_of = [&](const Ring& ring) { return ring.point[0] == 0.0 ? 1 : around; };
  Surface surface;
  int points = 0;
  for (const Ring& ring : rings) points += points_of(ring);
  surface.points.resize(3, points);
  surface.normals.resize(3, points);
  int upper = 0;  // first point of the ring above
  int first = 0;  // of this ring
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const Ring& ring = rings[i];
    for (int j = 0; j < points_of(ring); ++j) {
      const double azimuth_rad = 2.0 * std::numbers::pi * j / around;
      const auto turned = [&](const Eigen::Vector2d& v) {
        return Eigen::Vector3d(v[0] * std::cos(azimuth_rad), v[0] * std::sin(azimuth_rad), v[1]);
      };
      surface.normals.col(first + j) = turned(ring.normal);
      surface.points.col(first + j) = turned(ring.point) + ring.center * Eigen::Vector3d::UnitZ();
    }
    if (i > 0) {
      std::vector<std::int32_t> band;
      for (int j = 0; j <= around; ++j)
        band.insert(band.end(), {upper + j % points_of(rings[i - 1]), first + j % points_of(ring)});
      surface.join(band);
    }
    upper = first;
    first += points_of(ring);
  }
  return surface;
}

/// A cylinder along z closed by two half spheres; a sphere without the cylinder.
class Capsule final : public Solid {
 public:
  Capsule(double radius, double length) : radius_(radius), half_(0.5 * length) {}

  [[nodiscard]] double bounding_radius() const override { return half_ + radius_; }
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const override {
    return radius_ * direction.normalized() + Eigen::Vector3d(0.0, 0.0, std::copysign(half_, direction[2]));
  }
  void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const override {
    inside.clear();
    const Eigen::Vector3d end(0.0, 0.0, half_);
    Interval found;
    if (enters_ball(origin - end, direction, radius_, found)) inside.push_back(found);
    if (half_ > 0.0 && enters_ball(origin + end, direction, radius_, found)) inside.push_back(found);
    if (half_ > 0.0 && enters_cylinder(origin, direction, radius_, half_, found)) inside.push_back(found);
    if (inside.empty()) return;
    for (const Interval& part : inside)  // convex: there is one
      inside[0] = {std::min(inside[0].low, part.low), std::max(inside[0].high, part.high)};
    inside.resize(1);
  }
  [[nodiscard]] VolumeMoments moments() const override {
    const Shape shape{.kind = ShapeKind::capsule, .radius_m = radius_, .length_m = 2.0 * half_};
    VolumeMoments result;
    result.volume = volume_m3(shape);
    const Eigen::Vector3d I = inertia_tensor_kg_m2(shape, result.volume).diagonal();
    result.second.diagonal() = Eigen::Vector3d::Constant(0.5 * I.sum()) - I;
    return result;
  }
  /// The equator of a sphere is there once.
  [[nodiscard]] Surface surface(int around) const override {
    const int bands = around / 4;  // of a half sphere
    std::vector<Ring> rings;
    for (int band = 0; band <= 2 * bands; ++band) {
      const double polar_rad = std::numbers::pi * band / (2 * bands);
      const Eigen::Vector2d normal(band % (2 * bands) == 0 ? 0.0 : std::sin(polar_rad), std::cos(polar_rad));
      if (band <= bands) rings.push_back({radius_ * normal, normal, half_});
      if (band > bands || (band == bands && half_ > 0.0)) rings.push_back({radius_ * normal, normal, -half_});
    }
    return surface_of_rings(rings, around);
  }

 private:
  double radius_;
  double half_;
};

/// (x/a)² + (y/b)² + (z/c)² < 1
class Ellipsoid final : public Solid {
 public:
  explicit Ellipsoid(Eigen::Vector3d semi_axes) : semi_axes_(std::move(semi_axes)) {}

  [[nodiscard]] double bounding_radius() const override { return semi_axes_.maxCoeff(); }
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const override {
    return semi_axes_.cwiseProduct(semi_axes_.cwiseProduct(direction).normalized());
  }
  void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const override {
    Interval found;
    inside.clear();
    if (enters_ball(origin.cwiseQuotient(semi_axes_), direction.cwiseQuotient(semi_axes_), 1.0, found))
      inside.push_back(found);
  }
  [[nodiscard]] VolumeMoments moments() const override {
    VolumeMoments result;
    result.volume = 4.0 / 3.0 * std::numbers::pi * semi_axes_.prod();
    result.second.diagonal() = result.volume / 5.0 * semi_axes_.cwiseAbs2();
    return result;
  }
  [[nodiscard]] Surface surface(int around) const override {
    Surface unit = make_capsule(1.0, 0.0)->surface(around);
    unit.points = semi_axes_.asDiagonal() * unit.points;
    unit.normals = (semi_axes_.cwiseInverse().asDiagonal() * unit.normals).colwise().normalized();
    return unit;
  }

 private:
  Eigen::Vector3d semi_axes_;
};

/// With flat ends, along z.
class Cylinder final : public Solid {
 public:
  Cylinder(double radius, double length) : radius_(radius), half_(0.5 * length) {}

  [[nodiscard]] double bounding_radius() const override { return std::hypot(radius_, half_); }
  [[nodiscard]] Eigen::Vector3d support(const Eigen::Vector3d& direction) const override {
    return radius_ * across(direction).stableNormalized() +
           Eigen::Vector3d(0.0, 0.0, std::copysign(half_, direction[2]));
  }
  void crossings(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, Intervals& inside) const override {
    Interval found;
    inside.clear();
    if (enters_cylinder(origin, direction, radius_, half_, found)) inside.push_back(found);
  }
  [[nodiscard]] VolumeMoments moments() const override {
    VolumeMoments result;
    result.volume = std::numbers::pi * radius_ * radius_ * 2.0 * half_;
    const double round = result.volume * radius_ * radius_ / 4.0;
    result.second.diagonal() << round, round, result.volume * half_ * half_ / 3.0;
    return result;
  }
  [[nodiscard]] Surface surface(int around) const override {
    const Eigen::Vector2d up(0.0, 1.0);
    const Eigen::Vector2d out(1.0, 0.0);
    const Eigen::Vector2d axis(0.0, 0.0);
    const Eigen::Vector2d rim = radius_ * out;
    return surface_of_rings({{axis, up, half_},
                             {rim, up, half_},
                             {rim, out, half_},
                             {rim, out, -half_},
                             {rim, -up, -half_},
                             {axis, -up, -half_}},
                            around);
  }

 private:
  double radius_;
  double half_;
};

}  // namespace

std::unique_ptr<Solid> make_capsule(double radius, double length) { return std::make_unique<Capsule>(radius, length); }

std::unique_ptr<Solid> make_ellipsoid(const Eigen::Vector3d& semi_axes) {
  return std::make_unique<Ellipsoid>(semi_axes);
}

std::unique_ptr<Solid> make_cylinder(double radius, double length) {
  return std::make_unique<Cylinder>(radius, length);
}

}  // namespace copepod
