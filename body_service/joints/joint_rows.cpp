#include "joints/joint_rows.hpp"

#include <cmath>

#include <Eigen/Geometry>

#include "contract/errors.hpp"

namespace copepod::body {

namespace {

/// A point on each side, the vector d from B's to A's, and what its derivatives have in common.
struct Anchors {
  Anchors(const JointSide& A, const JointSide& B, const Eigen::Vector3d& anchor_A_m, const Eigen::Vector3d& anchor_B_m)
      : arm_A_m(A.R_WB * anchor_A_m), arm_B_m(B.R_WB * anchor_B_m) {
    const Eigen::Vector3d& w_A = A.angular_velocity_rad_per_s;
    const Eigen::Vector3d& w_B = B.angular_velocity_rad_per_s;
    apart_m = (A.position_m - B.position_m) + (arm_A_m - arm_B_m);
    rate_m_per_s = (A.velocity_m_per_s - B.velocity_m_per_s) + (w_A.cross(arm_A_m) - w_B.cross(arm_B_m));
    centripetal_m_per_s2 = w_A.cross(w_A.cross(arm_A_m)) - w_B.cross(w_B.cross(arm_B_m));
  }

  /// The row of e · d for a direction e at rest in the world.
  [[nodiscard]] JointRow along(const Eigen::Vector3d& e) const {
    return {{e, -e}, {arm_A_m.cross(e), e.cross(arm_B_m)}, e.dot(apart_m), e.dot(centripetal_m_per_s2)};
  }

  Eigen::Vector3d arm_A_m;
  Eigen::Vector3d arm_B_m;
  Eigen::Vector3d apart_m;               ///< d
  Eigen::Vector3d rate_m_per_s;          ///< dd/dt
  Eigen::Vector3d centripetal_m_per_s2;  ///< d²d/dt² less the accelerations of the bodies
};

/// u · w = 0 for u fixed in A and w fixed in B:
///   dC/dt = n · (ω_A − ω_B),   n = u × w,   c = dn/dt · (ω_A − ω_B)                             (B28)
JointRow perpendicular(const Eigen::Vector3d& u, const Eigen::Vector3d& w, const JointSide& A, const JointSide& B) {
  const Eigen::Vector3d& w_A = A.angular_velocity_rad_per_s;
  const Eigen::Vector3d& w_B = B.angular_velocity_rad_per_s;
  const Eigen::Vector3d n = u.cross(w);
  const Eigen::Vector3d n_rate = w_A.cross(u).cross(w) + u.cross(w_B.cross(w));
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return {{none, none}, {n, -n}, u.dot(w), n_rate.dot(w_A - w_B)};
}

/// u · w = 0 for u fixed in A and w in B, but turned about an axis a of B by the angle s of the drive; as above, with
/// ω_B + ṡ a in place of ω_B.                                                                     (B30)
JointRow turned(const Eigen::Vector3d& u, const Eigen::Vector3d& w_at_start, const Eigen::Vector3d& axis,
                const JointMotion& motion, const JointSide& A, const JointSide& B) {
  const Eigen::Vector3d w = Eigen::AngleAxisd(motion.value, axis) * w_at_start;
  JointSide frame = B;
  frame.angular_velocity_rad_per_s += motion.rate * axis;
  JointRow row = perpendicular(u, w, A, frame);
  const Eigen::Vector3d& n = row.angular[0];
  row.drift = -motion.rate * n.dot(axis);
  row.curvature -= n.dot(motion.acceleration * axis + motion.rate * B.angular_velocity_rad_per_s.cross(axis));
  return row;
}

/// e · d = 0 for a direction e that turns with B:
///   dC/dt = e · dd/dt + ω_B · (e × d),   c = e · c_d + 2 (ω_B × e) · dd/dt + (ω_B × (ω_B × e)) · d      (B27)
JointRow across(const Eigen::Vector3d& e, const Anchors& anchors, const JointSide& B) {
  const Eigen::Vector3d& w_B = B.angular_velocity_rad_per_s;
  const Eigen::Vector3d e_rate = w_B.cross(e);
  JointRow row = anchors.along(e);
  row.angular[1] += e.cross(anchors.apart_m);
  row.curvature += 2.0 * e_rate.dot(anchors.rate_m_per_s) + w_B.cross(e_rate).dot(anchors.apart_m);
  return row;
}

/// |d| − l = 0:
///   dC/dt = n · dd/dt,   n = d/|d|,   c = n · c_d + (|dd/dt|² − (n · dd/dt)²)/|d|               (B29)
JointRow rod(const Anchors& anchors, double length_m) {
  const double now_m = anchors.apart_m.norm();
  if (!(now_m > 0.0))
    throw SolverError("the ends of a distance joint coincide (it has no direction). Use a shorter step.");
  const Eigen::Vector3d n = anchors.apart_m / now_m;
  const double along_m_per_s = n.dot(anchors.rate_m_per_s);
  JointRow row = anchors.along(n);
  row.error = now_m - length_m;
  row.curvature += (anchors.rate_m_per_s.squaredNorm() - along_m_per_s * along_m_per_s) / now_m;
  return row;
}

/// C = C₀ − s for a joint of which C₀ is the motion.                                              (B30)
JointRow driven_by(const JointMotion& motion, JointRow row) {
  row.error -= motion.value;
  row.drift -= motion.rate;
  row.curvature -= motion.acceleration;
  return row;
}

Eigen::Matrix3d frame_about(const Eigen::Vector3d& axis) {
  Eigen::Index smallest = 0;
  axis.cwiseAbs().minCoeff(&smallest);
  Eigen::Matrix3d frame;
  frame.col(2) = axis.normalized();
  frame.col(0) = frame.col(2).cross(Eigen::Vector3d::Unit(smallest)).normalized();
  frame.col(1) = frame.col(2).cross(frame.col(0));
  return frame;
}

}  // namespace

JointEquations::JointEquations(const JointSpecification& specification, bool driven, const JointSide& A,
                               const JointSide& B)
    : kind_(specification.kind),
      driven_(driven),
      anchor_A_m_(specification.anchor_A_m),
      anchor_B_m_(specification.anchor_B_m),
      frame_A_(frame_about(specification.axis)),
      frame_B_(B.R_WB.transpose() * A.R_WB * frame_A_),
      length_m_(Anchors(A, B, anchor_A_m_, anchor_B_m_).apart_m.norm()) {}

int JointEquations::rows() const {
  switch (kind_) {
    case JointKind::ball:
      return 3;
    case JointKind::hinge:
    case JointKind::slider:
      return driven_ ? 6 : 5;
    case JointKind::fixed:
      return 6;
    case JointKind::distance:
      return 1;
    case JointKind::model:
      break;  // not announced
  }
  return 0;
}

void JointEquations::evaluate(const JointSide& A, const JointSide& B, const JointMotion& motion, JointRow* rows) const {
  if (kind_ == JointKind::model) return;
  const Anchors anchors(A, B, anchor_A_m_, anchor_B_m_);
  if (kind_ == JointKind::distance) {
    *rows = driven_by(motion, rod(anchors, length_m_));
    return;
  }
  const Eigen::Matrix3d axes_A = A.R_WB * frame_A_;
  const Eigen::Matrix3d axes_B = B.R_WB * frame_B_;
  if (kind_ == JointKind::slider) {
    for (const int i : {0, 1}) *rows++ = across(axes_B.col(i), anchors, B);
    if (driven_) *rows++ = driven_by(motion, across(axes_B.col(2), anchors, B));
  } else {
    for (int i = 0; i < 3; ++i) *rows++ = anchors.along(Eigen::Vector3d::Unit(i));  // (B26)
  }
  if (kind_ == JointKind::ball) return;
  *rows++ = perpendicular(axes_A.col(2), axes_B.col(0), A, B);
  *rows++ = perpendicular(axes_A.col(2), axes_B.col(1), A, B);
  if (kind_ != JointKind::hinge)
    *rows++ = perpendicular(axes_A.col(0), axes_B.col(1), A, B);
  else if (driven_)
    *rows++ = turned(axes_A.col(0), axes_B.col(1), axes_B.col(2), motion, A, B);
}

JointRow JointEquations::motion(const JointSide& A, const JointSide& B) const {
  const Eigen::Matrix3d axes_B = B.R_WB * frame_B_;
  const Eigen::Vector3d axis = axes_B.col(2);
  if (kind_ == JointKind::slider) return across(axis, Anchors(A, B, anchor_A_m_, anchor_B_m_), B);
  const Eigen::Vector3d u = A.R_WB * frame_A_.col(0);
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  return {{none, none}, {axis, -axis}, std::atan2(u.dot(axes_B.col(1)), u.dot(axes_B.col(0)))};
}

}  // namespace copepod::body
