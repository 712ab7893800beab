#include "lattice_boltzmann/bodies/lattice_body.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace copepod::fluid {

namespace {

/// Interval of the real line; empty if low > high.
struct Interval {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double a, double b) {
    low = std::min(low, a);
    high = std::max(high, b);
  }
};

/// std::floor, which is a call without SSE4.1.
std::int64_t floor_of(double x) {
  const auto towards_zero = static_cast<std::int64_t>(x);
  return towards_zero - static_cast<std::int64_t>(static_cast<double>(towards_zero) > x);
}

/// Adds the part of the line (dx, dy, z) inside a sphere around `centre`.
void include_sphere(Interval& span, double dx, double dy, const Eigen::Vector3d& centre, double radius) {
  const double ex = dx - centre[0];
  const double ey = dy - centre[1];
  const double square = radius * radius - (ex * ex + ey * ey);
  if (square <= 0.0) return;
  const double half = std::sqrt(square);
  span.include(centre[2] - half, centre[2] + half);
}

/// Adds the part of the line w + z e_z, w = (dx, dy, 0), inside an ellipsoid:
///   A_zz z² + 2 (A w)_z z + w·A w < 1
void include_ellipsoid(Interval& span, double dx, double dy, const Eigen::Matrix3d& A) {
  const Eigen::Vector3d w(dx, dy, 0.0);
  const Eigen::Vector3d A_w = A * w;
  const double discriminant = A_w[2] * A_w[2] - A(2, 2) * (w.dot(A_w) - 1.0);
  if (discriminant <= 0.0) return;
  const double root = std::sqrt(discriminant);
  span.include((-A_w[2] - root) / A(2, 2), (root - A_w[2]) / A(2, 2));
}

/// Adds the part of the line w + z e_z, w = (dx, dy, 0), inside the cylinder |p − (p·a)a| < R, |p·a| < h:
///   (1 − a_z²) z² − 2 (w·a) a_z z + |w|² − (w·a)² < R²,   |w·a + z a_z| < h
void include_cylinder(Interval& span, double dx, double dy, const LatticeBody& body) {
  const Eigen::Vector3d& a = body.axis;
  const double wa = dx * a[0] + dy * a[1];
  const double constant = dx * dx + dy * dy - wa * wa - body.radius * body.radius;
  double low = -std::numeric_limits<double>::infinity();
  double high = -low;
  const double across = 1.0 - a[2] * a[2];
  if (across > 1e-12) {
    const double half_linear = wa * a[2];
    const double discriminant = half_linear * half_linear - across * constant;
    if (discriminant <= 0.0) return;
    low = (half_linear - std::sqrt(discriminant)) / across;
    high = (half_linear + std::sqrt(discriminant)) / across;
  } else if (constant >= 0.0) {
    return;
  }
  if (std::abs(a[2]) > 1e-12) {
    const double one = (-body.half_length - wa) / a[2];
    const double two = (body.half_length - wa) / a[2];
    low = std::max(low, std::min(one, two));
    high = std::min(high, std::max(one, two));
  } else if (std::abs(wa) >= body.half_length) {
    return;
  }
  if (low < high) span.include(low, high);
}

}  // namespace

void LatticeBody::place(const Eigen::Vector3d& at, const Eigen::Quaterniond& orientation) {
  const Eigen::Quaterniond q = orientation.normalized();
  position = at;
  axis = q * Eigen::Vector3d::UnitZ();
  if (kind == ShapeKind::ellipsoid) {
    const Eigen::Matrix3d R = q.toRotationMatrix();
    const Eigen::Matrix3d stretch = semi_axes_.cwiseInverse().asDiagonal() * R.transpose();
    form.noalias() = stretch.transpose() * stretch;
    half_extents_ = (R * semi_axes_.asDiagonal()).rowwise().norm();
  }
  const bool stays = !shape_ || (placed && placed->is_at(at, q));
  if (stays || !at.allFinite() || !axis.allFinite()) return;
  placed = fluid::place(*shape_, at, q, cell_m_);
  const Eigen::Vector3d link = Eigen::Vector3d::Constant(1.5);  // more than the longest along an axis
  reached_from_ = {placed->bounds().min() - link, placed->bounds().max() + link};
  images_ = {Eigen::Vector3d::Zero()};
  for (int i = 0; i < 3; ++i) {
    if (period[i] == 0.0) continue;
    // A link begins within half a period of the position, or a cell further, and is up to a cell long.
    const double first = std::ceil(-0.5 - (placed->bounds().max()[i] + 2.0) / period[i]);
    const double last = std::floor(0.5 - (placed->bounds().min()[i] - 2.0) / period[i]);
    const std::vector<Eigen::Vector3d> across = std::move(images_);
    images_.clear();
    for (double image = first; image <= last; ++image)
      for (const Eigen::Vector3d& other : across)
        images_.emplace_back(other + image * period[i] * Eigen::Vector3d::Unit(i));
  }
}

double LatticeBody::entry_into_images(const Eigen::Vector3d& r, int direction) const {
  double q = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& image : images_)
    if (reached_from_.contains(r - image)) q = std::min(q, placed->entry(r - image, direction));
  return q;
}

/// Centres k + 1/2.
RowInterval cells_between(double low, double high) { return {floor_of(low - 0.5) + 1, -floor_of(-(high - 0.5))}; }

RowInterval covered_cells(const LatticeBody& body, std::int64_t x, std::int64_t y) {
  const double dx = (static_cast<double>(x) + 0.5) - body.position[0];
  const double dy = (static_cast<double>(y) + 0.5) - body.position[1];
  Interval span;
  if (body.kind == ShapeKind::sphere) {
    include_sphere(span, dx, dy, Eigen::Vector3d::Zero(), body.radius);
  } else if (body.kind == ShapeKind::ellipsoid) {
    include_ellipsoid(span, dx, dy, body.form);
  } else {
    include_sphere(span, dx, dy, body.half_length * body.axis, body.radius);
    include_sphere(span, dx, dy, -body.half_length * body.axis, body.radius);
    include_cylinder(span, dx, dy, body);
  }
  if (!(span.low < span.high)) return {};
  return cells_between(body.position[2] + span.low, body.position[2] + span.high);
}

void add_crossings(const LatticeBody& body, std::vector<RowCrossing>& crossings) {
  if (body.placed) return body.placed->add_crossings(crossings);
  for_each_row(body.bounds(), body.position,
               [&](std::int64_t x, std::int64_t y) { append(crossings, x, y, covered_cells(body, x, y)); });
}

void append(std::vector<RowCrossing>& crossings, std::int64_t x, std::int64_t y, const RowInterval& cells) {
  if (cells.empty()) return;
  crossings.push_back({x, y, cells.low, 1});
  crossings.push_back({x, y, cells.high, -1});
}

double entry_into_capsule(const LatticeBody& capsule, const Eigen::Vector3d& r, const Eigen::Vector3d& e) {
  const Eigen::Vector3d end = capsule.half_length * capsule.axis;
  double q = std::min(entry_into_sphere(r - end, e, capsule.radius), entry_into_sphere(r + end, e, capsule.radius));
  if (capsule.half_length > 0.0) {
    const auto across = [&](const Eigen::Vector3d& v) -> Eigen::Vector3d {
      return v - v.dot(capsule.axis) * capsule.axis;
    };
    const double side = entry_into_sphere(across(r), across(e), capsule.radius);
    if (side < q && std::abs((r + side * e).dot(capsule.axis)) <= capsule.half_length) q = side;
  }
  return q;
}

}  // namespace copepod::fluid
