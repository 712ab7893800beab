#pragma once

#include <Eigen/Core>

namespace copepod::coupler {

/// A rigid motion of a group of points: p → c + t + R (p − c), c the centroid.
struct RigidMotion {
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();  ///< t, of the centroid
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();   ///< R, proper
};

/// The rigid motion that takes points as close as possible, in the sense of least squares, to where they are later
/// (Kabsch, Acta Cryst. A 32, 922 (1976); docs/theory.md, (C13)).
///   H = Σ (p − c)(p' − c')ᵀ = U S Vᵀ,   R = V diag(1, 1, det(V Uᵀ)) Uᵀ
/// For points on a line the rotation about that line is undetermined, and the shortest rotation that turns the line is
/// returned; the same holds where the points leave their line by less than a thousandth of its length, before or after.
/// A single point does not rotate.
/// @param before, after  shape (3, points), at least one point, equal weights
RigidMotion fit_rigid_motion(const Eigen::Matrix3Xd& before, const Eigen::Matrix3Xd& after);

/// Shortest rotation from one unit vector to another; a half turn about any perpendicular axis for opposite ones.
///   R = I + [w]ₓ + [w]ₓ² / (1 + c),   w = from × to,   c = from · to
Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

/// Axis times angle of a rotation, the angle in [0, π] [rad].
Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation);

}  // namespace copepod::coupler
