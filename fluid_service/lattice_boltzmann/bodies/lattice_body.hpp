#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "contract/exchange.hpp"
#include "contract/shape.hpp"
#include "lattice_boltzmann/bodies/placed_shape.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"
#include "lattice_boltzmann/lattice/lattice_units.hpp"

namespace copepod::fluid {

/// Whether bodies of a shape are PlacedShapes on the lattice.
inline bool is_placed(const Shape& shape) { return !is_round(shape) && shape.kind != ShapeKind::ellipsoid; }

/// A rigid body in lattice units, world frame; lengths in cells.
struct LatticeBody {
  ShapeKind kind = ShapeKind::sphere;
  double radius = 0.0;       ///< of a sphere or capsule
  double half_length = 0.0;  ///< of the capsule's cylinder part
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of the capsule; of other shapes the z axis
  Eigen::Matrix3d form = Eigen::Matrix3d::Zero();   ///< of an ellipsoid r·A r = 1: A
  std::shared_ptr<const PlacedShape> placed;        ///< of shapes with is_placed
  /// Of an obstacle: distance of its images along each axis, 0 if none. It may be longer, so that links enter images
  /// that are not the nearest to its position.
  Eigen::Array3d period = Eigen::Array3d::Zero();
  bool has_loads = true;  ///< whether the case asks for those on an obstacle

  LatticeBody() = default;
  LatticeBody(const Shape& shape, double cell_m)
      : kind(shape.kind),
        radius(shape.radius_m / cell_m),
        half_length(core_half_length_m(shape) / cell_m),
        cell_m_(cell_m),
        semi_axes_(shape.extents_m / cell_m),
        shape_(is_placed(shape) ? std::make_shared<const Shape>(shape) : nullptr) {}

  void move(const Kinematics& kinematics, Eigen::Index body, const LatticeUnits& units) {
    velocity = units.velocity_lu(kinematics.velocity_m_per_s.col(body));
    angular_velocity = units.angular_velocity_lu(kinematics.angular_velocity_rad_per_s.col(body));
    if (kind == ShapeKind::sphere) {
      position = units.position_lu(kinematics.position_m.col(body));
    } else {
      const Eigen::Vector4d q = kinematics.orientation_wxyz.col(body);
      place(units.position_lu(kinematics.position_m.col(body)), {q[0], q[1], q[2], q[3]});
    }
  }
  void place(const Eigen::Vector3d& at, const Eigen::Quaterniond& orientation);

  /// Whether it has the place of another state of the same body.
  [[nodiscard]] bool is_turned_as(const LatticeBody& other) const {
    return axis == other.axis && placed == other.placed && form == other.form;
  }

  /// Axis-aligned bounding box, relative to the position.
  [[nodiscard]] Eigen::AlignedBox3d bounds() const {
    if (placed) return placed->bounds();
    if (kind == ShapeKind::ellipsoid) return {-half_extents_, half_extents_};
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(radius) + half_length * axis.cwiseAbs();
    return {-half, half};
  }

  /// Where a link first enters `placed` or an image of it.
  [[nodiscard]] double entry_into_images(const Eigen::Vector3d& r, int direction) const;

  /// u_w = U + Ω × r
  [[nodiscard]] Eigen::Vector3d surface_velocity(const Eigen::Vector3d& r) const {
    return velocity + angular_velocity.cross(r);
  }

 private:
  double cell_m_ = 1.0;
  Eigen::Vector3d semi_axes_ = Eigen::Vector3d::Zero();     ///< of an ellipsoid
  Eigen::Vector3d half_extents_ = Eigen::Vector3d::Zero();  ///< likewise, along the lattice
  std::shared_ptr<const Shape> shape_;                      ///< if it is placed
  std::vector<Eigen::Vector3d> images_;                     ///< those that links may enter, from the position
  Eigen::AlignedBox3d reached_from_;                        ///< where links into one of them begin, from its position
};

/// Half-open range of cells [low, high) along z, in cells counted without wrapping; empty if low ≥ high.
struct RowInterval {
  std::int64_t low = 0;
  std::int64_t high = 0;

  [[nodiscard]] bool empty() const { return low >= high; }
  bool operator==(const RowInterval&) const = default;
};

inline Eigen::Vector3d centre_of_cell(std::int64_t x, std::int64_t y, std::int64_t z) {
  return {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5, static_cast<double>(z) + 0.5};
}

/// Cells whose centres lie strictly between two heights.
RowInterval cells_between(double low, double high);

/// visit(x, y) for the rows of cells along z that meet a box around a position.
template <class Visit>
void for_each_row(const Eigen::AlignedBox3d& bounds, const Eigen::Vector3d& position, const Visit& visit) {
  const auto low = [&](int axis) { return static_cast<std::int64_t>(std::floor(position[axis] + bounds.min()[axis])); };
  const auto high = [&](int axis) {
    return static_cast<std::int64_t>(std::floor(position[axis] + bounds.max()[axis]));
  };
  for (std::int64_t x = low(0); x <= high(0); ++x)
    for (std::int64_t y = low(1); y <= high(1); ++y) visit(x, y);
}

/// Cells of row (x, y) whose centres lie inside a body that is not placed: convex, so that they form one interval.
///
/// A sphere cuts the row's line at z = Z ± √(R² − dx² − dy²). A capsule is the convex hull of its two end
/// spheres: the interval reaches from the lowest to the highest point of the line in the two spheres and in
/// the cylinder between.
RowInterval covered_cells(const LatticeBody& body, std::int64_t x, std::int64_t y);

/// Appends where rows enter and leave a body of any shape.
void add_crossings(const LatticeBody& body, std::vector<RowCrossing>& crossings);
void append(std::vector<RowCrossing>& crossings, std::int64_t x, std::int64_t y, const RowInterval& cells);

/// First root q ≥ 0 of square q² + 2 half_linear q + constant; infinity without one, and where constant < 0.
inline double first_root(double square, double half_linear, double constant) {
  const double linear = -half_linear;
  const double discriminant = linear * linear - square * constant;
  if (linear <= 0.0 || constant < 0.0 || discriminant < 0.0) return std::numeric_limits<double>::infinity();
  return constant / (linear + std::sqrt(discriminant));  // without cancellation where q is small
}

/// First root q of |r + q e|² = R² along a link that starts outside; infinity if the line misses.
inline double entry_into_sphere(const Eigen::Vector3d& r, const Eigen::Vector3d& e, double radius) {
  return first_root(e.squaredNorm(), r.dot(e), r.squaredNorm() - radius * radius);
}

/// The same for an ellipsoid: (r + q e)·A (r + q e) = 1. Sums are in the order of exchange_groups.
inline double entry_into_ellipsoid(const Eigen::Matrix3d& A, const Eigen::Vector3d& r, const Eigen::Vector3d& e) {
  const auto dot = [](const double* a, const double* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  double A_r[3], A_e[3];
  for (int axis = 0; axis < 3; ++axis) {
    A_r[axis] = dot(&A(0, axis), r.data());
    A_e[axis] = dot(&A(0, axis), e.data());
  }
  return first_root(dot(e.data(), A_e), dot(e.data(), A_r), dot(r.data(), A_r) - 1.0);
}

/// The same for a capsule: the first of its end spheres and its cylinder.
double entry_into_capsule(const LatticeBody& capsule, const Eigen::Vector3d& r, const Eigen::Vector3d& e);

/// Where a link first enters a body, in its own length; infinity if it misses.
/// @param r  from the body's centre to the cell centre where the link begins, outside the body
inline double entry(const LatticeBody& body, const Eigen::Vector3d& r, int direction) {
  const Eigen::Map<const Eigen::Vector3d> e(d3q19::velocity[direction].data());
  if (body.kind == ShapeKind::sphere) return entry_into_sphere(r, e, body.radius);
  if (body.kind == ShapeKind::ellipsoid) return entry_into_ellipsoid(body.form, r, e);
  return body.placed ? body.entry_into_images(r, direction) : entry_into_capsule(body, r, e);
}

/// Where the link x_f → x_f + e_α crosses the surface: q in [0, 1], with the wall at x_f + q e. Exact:
///   |r + q e − c|² = R², with c = 0 for the sphere and the centres of the end spheres for the capsule;
///   |(r + q e)⊥|² = R² for the capsule's cylinder, ⊥ normal to its axis.
/// @param r  from the body's centre to x_f, outside the body; r + e_α is inside
inline double wall_distance(const LatticeBody& body, const Eigen::Vector3d& r, int direction) {
  return std::min(entry(body, r, direction), 1.0);  // a centre that is covered by rounding only
}

}  // namespace copepod::fluid
