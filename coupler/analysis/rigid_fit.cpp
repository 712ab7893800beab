#include "analysis/rigid_fit.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace copepod::coupler {

Eigen::Matrix3d shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double c = from.dot(to);
  if (c < -1.0 + 1e-12) {
    const Eigen::Vector3d n = from.unitOrthogonal();
    return 2.0 * n * n.transpose() - Eigen::Matrix3d::Identity();
  }
  const Eigen::Vector3d w = from.cross(to);
  Eigen::Matrix3d cross;
  cross << 0, -w.z(), w.y(), w.z(), 0, -w.x(), -w.y(), w.x(), 0;
  return Eigen::Matrix3d::Identity() + cross + cross * cross / (1.0 + c);
}

Eigen::Vector3d rotation_vector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(rotation)};
  return turn.angle() * turn.axis();
}

namespace {

/// Whether points about their centroid leave a line by less than a thousandth of their extent along it.
bool is_row(const Eigen::Matrix3Xd& points) {
  const Eigen::Matrix3d moments = points * points.transpose();
  const Eigen::Vector3d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(moments).eigenvalues();
  return squares[1] <= 1e-6 * squares[2];
}

}  // namespace

RigidMotion fit_rigid_motion(const Eigen::Matrix3Xd& before, const Eigen::Matrix3Xd& after) {
  const Eigen::Vector3d from = before.rowwise().mean(), to = after.rowwise().mean();
  RigidMotion motion;
  motion.translation_m = to - from;
  const Eigen::Matrix3Xd p = before.colwise() - from, q = after.colwise() - to;
  const Eigen::Matrix3d covariance = p * q.transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &U = svd.matrixU(), &V = svd.matrixV();
  const Eigen::Vector3d& S = svd.singularValues();
  if (S[0] == 0.0) return motion;
  if (is_row(p) || is_row(q)) {
    motion.rotation = shortest_rotation(U.col(0), V.col(0));
    return motion;
  }
  const double handedness = (V * U.transpose()).determinant() < 0.0 ? -1.0 : 1.0;
  motion.rotation = V * Eigen::Vector3d(1.0, 1.0, handedness).asDiagonal() * U.transpose();
  return motion;
}

}  // namespace copepod::coupler
