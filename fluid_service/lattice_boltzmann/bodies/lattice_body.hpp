#pragma once

#include <algorithm>

#include <Eigen/Geometry>

#include "contract/exchange.hpp"
#include "contract/shape.hpp"
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

  /// Signed distance of a point to the surface, negative inside.
  /// @param r  from the centre of mass to the point
  [[nodiscard]] double signed_distance(const Eigen::Vector3d& r) const {
    if (kind == ShapeKind::sphere) return r.norm() - radius;
    const double along = std::clamp(r.dot(axis), -half_length, half_length);
    return (r - along * axis).norm() - radius;
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

}  // namespace copepod::fluid
