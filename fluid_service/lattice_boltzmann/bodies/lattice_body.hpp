#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Geometry>

#include "contract/exchange.hpp"
#include "contract/shape.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"
#include "lattice_boltzmann/lattice/lattice_units.hpp"

namespace copepod::fluid {

/// A rigid body in lattice units, world frame; lengths in cells.
struct LatticeBody {
  ShapeKind kind = ShapeKind::sphere;
  double radius = 0.0;
  double half_length = 0.0;  ///< of the cylinder part
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< of the capsule

  LatticeBody() = default;
  LatticeBody(const Shape& shape, const LatticeUnits& units)
      : kind(shape.kind),
        radius(units.length_lu(shape.radius_m)),
        half_length(shape.kind == ShapeKind::capsule ? 0.5 * units.length_lu(shape.length_m) : 0.0) {}

  void move(const Kinematics& kinematics, Eigen::Index body, const LatticeUnits& units) {
    position = units.position_lu(kinematics.position_m.col(body));
    velocity = units.velocity_lu(kinematics.velocity_m_per_s.col(body));
    angular_velocity = units.angular_velocity_lu(kinematics.angular_velocity_rad_per_s.col(body));
    if (kind == ShapeKind::capsule) {
      const Eigen::Vector4d q = kinematics.orientation_wxyz.col(body);
      axis = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized() * Eigen::Vector3d::UnitZ();
    }
  }

  /// Half extents of the axis-aligned bounding box.
  [[nodiscard]] Eigen::Vector3d half_extents() const {
    return Eigen::Vector3d::Constant(radius) + half_length * axis.cwiseAbs();
  }

  /// u_w = U + Ω × r
  [[nodiscard]] Eigen::Vector3d surface_velocity(const Eigen::Vector3d& r) const {
    return velocity + angular_velocity.cross(r);
  }
};

/// Half-open range of cells [low, high) along z, in cells counted without wrapping; empty if low ≥ high.
struct RowInterval {
  std::int64_t low = 0;
  std::int64_t high = 0;

  [[nodiscard]] bool empty() const { return low >= high; }
  bool operator==(const RowInterval&) const = default;
};

/// Cells of row (x, y) whose centres lie inside a body: bodies are convex, so they form one interval.
///
/// A sphere cuts the row's line at z = Z ± √(R² − dx² − dy²). A capsule is the convex hull of its two end
/// spheres: the interval reaches from the lowest to the highest point of the line in the two spheres and in
/// the cylinder between.
RowInterval covered_cells(const LatticeBody& body, std::int64_t x, std::int64_t y);

/// First root q of |r + q e|² = R² along a link that starts outside; infinity if the line misses.
inline double entry_into_sphere(const Eigen::Vector3d& r, const Eigen::Vector3d& e, double radius) {
  const double linear = -r.dot(e);
  const double constant = r.squaredNorm() - radius * radius;
  const double discriminant = linear * linear - e.squaredNorm() * constant;
  if (linear <= 0.0 || constant < 0.0 || discriminant < 0.0) return std::numeric_limits<double>::infinity();
  return constant / (linear + std::sqrt(discriminant));  // without cancellation where q is small
}

/// The same for a capsule: the first of its end spheres and its cylinder.
double entry_into_capsule(const LatticeBody& capsule, const Eigen::Vector3d& r, const Eigen::Vector3d& e);

/// Where the link x_f → x_f + e_α crosses the surface: q in [0, 1], with the wall at x_f + q e. Exact:
///   |r + q e − c|² = R², with c = 0 for the sphere and the centres of the end spheres for the capsule;
///   |(r + q e)⊥|² = R² for the capsule's cylinder, ⊥ normal to its axis.
/// @param r  from the body's centre to x_f, outside the body; r + e_α is inside
inline double wall_distance(const LatticeBody& body, const Eigen::Vector3d& r, int direction) {
  const auto& e = d3q19::velocity[static_cast<std::size_t>(direction)];
  const Eigen::Vector3d link(e[0], e[1], e[2]);
  const double q =
      body.kind == ShapeKind::sphere ? entry_into_sphere(r, link, body.radius) : entry_into_capsule(body, r, link);
  return std::min(q, 1.0);  // a centre that is covered by rounding only
}

}  // namespace copepod::fluid
