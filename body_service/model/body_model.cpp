#include "model/body_model.hpp"

#include <cmath>

#include "constraints/motion_constraint.hpp"
#include "contract/errors.hpp"
#include "contract/words.hpp"

namespace copepod::body {

namespace {

[[noreturn]] void reject(const BodySpecification& body, const std::string& reason) {
  throw CaseError("body '" + body.name + "': " + reason);
}

void check(const BodySpecification& body) {
  if (!(body.mass_kg > 0.0) || !std::isfinite(body.mass_kg)) {
    reject(body, "mass_kg " + rounded_text(body.mass_kg) + " (a body needs a finite mass > 0). Use a positive mass.");
  }
  if (!(body.shape.radius_m > 0.0) || !std::isfinite(body.shape.radius_m)) {
    reject(body, "radius_m " + rounded_text(body.shape.radius_m) +
                     " (a shape needs a finite extent > 0). Use a positive radius.");
  }
  if (body.shape.kind == ShapeKind::capsule && (!(body.shape.length_m >= 0.0) || !std::isfinite(body.shape.length_m))) {
    reject(body,
           "length_m " + rounded_text(body.shape.length_m) + " (the cylinder part cannot be negative). Use 0 or more.");
  }
  if (!(std::abs(body.orientation_wxyz.norm() - 1.0) < 1e-6)) {
    reject(body, "orientation_wxyz has norm " + rounded_text(body.orientation_wxyz.norm()) +
                     " (a rotation is a unit quaternion). Divide it by its norm.");
  }
  if (!body.position_m.allFinite() || !body.velocity_m_per_s.allFinite() ||
      !body.angular_velocity_rad_per_s.allFinite()) {
    reject(body, "its initial state is not finite (a number is inf or NaN). Use finite numbers.");
  }
}

/// Diagonal of the inverse inertia with which the body answers to torques, see MotionState.
Eigen::Vector3d inverse_inertia(const BodySpecification& body, const Eigen::Vector4d& q_WB) {
  const Eigen::Matrix3d inertia_B = inertia_tensor_kg_m2(body.shape, body.mass_kg);
  switch (body.motion) {
    case MotionKind::free:
      return inertia_B.diagonal().cwiseInverse();
    case MotionKind::axis: {
      // Turning about an axis through the centre of mass does not change aᵀ I a: one number serves for the
      // whole run.
      const Eigen::Vector3d axis_B = rotation_matrix(q_WB).transpose() * body.axis.normalized();
      return Eigen::Vector3d::Constant(1.0 / axis_B.dot(inertia_B * axis_B));
    }
    case MotionKind::fixed:
    case MotionKind::prescribed:
      break;
  }
  return Eigen::Vector3d::Ones();
}

}  // namespace

Eigen::Matrix3d inertia_tensor_kg_m2(const Shape& shape, double mass_kg) {
  const MomentsOfInertia moments = moments_of_inertia(shape, mass_kg);
  return Eigen::Vector3d(moments.across_kg_m2, moments.across_kg_m2, moments.along_kg_m2).asDiagonal();
}

BodyModel::BodyModel(const BodySetup& setup) {
  const auto bodies = static_cast<Eigen::Index>(setup.bodies.size());
  names_.reserve(setup.bodies.size());
  shapes_.reserve(setup.bodies.size());
  motions_.reserve(setup.bodies.size());
  isotropic_.reserve(setup.bodies.size());
  axis_.resize(3, bodies);
  inverse_mass_per_kg_.resize(bodies);
  inverse_inertia_.resize(3, bodies);
  initial_.resize(bodies);
  for (Eigen::Index body = 0; body < bodies; ++body) add(body, setup.bodies[body]);
}

void BodyModel::add(Eigen::Index body, const BodySpecification& specification) {
  check(specification);
  const BodyVelocities velocities = constrained_velocities(specification);
  const Eigen::Vector4d q_WB = specification.orientation_wxyz.normalized();

  names_.push_back(specification.name);
  shapes_.push_back(specification.shape);
  motions_.push_back(specification.motion);
  axis_.col(body) = specification.axis.normalized();
  inverse_mass_per_kg_[body] = 1.0 / specification.mass_kg;
  inverse_inertia_.col(body) = inverse_inertia(specification, q_WB);
  isotropic_.push_back((inverse_inertia_.col(body).array() == inverse_inertia_(0, body)).all() ? 1 : 0);

  initial_.position_m.col(body) = specification.position_m;
  initial_.orientation_wxyz.col(body) = q_WB;
  initial_.velocity_m_per_s.col(body) = velocities.linear_m_per_s;
  const Eigen::Matrix3d R_WB = isotropic_[body] != 0 ? Eigen::Matrix3d::Identity() : rotation_matrix(q_WB);
  const Eigen::Vector3d w_B = R_WB.transpose() * velocities.angular_rad_per_s;
  initial_.angular_momentum_N_m_s.col(body) = R_WB * w_B.cwiseQuotient(inverse_inertia_.col(body));
}

}  // namespace copepod::body
