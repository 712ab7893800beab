#include "model/body_model.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::body {

namespace {

[[noreturn]] void reject(const BodySpecification& body, const std::string& reason) {
  throw CaseError("body '" + body.name + "': " + reason);
}

bool is_positive(double number) { return number > 0.0 && std::isfinite(number); }

void check_shape(const BodySpecification& body, const Shape& shape) {
  const bool has_radius = is_round(shape) || shape.kind == ShapeKind::cylinder || &shape == &body.shape;
  if (has_radius && !is_positive(shape.radius_m))
    reject(body,
           "radius_m " + rounded_text(shape.radius_m) + " (a shape needs a finite extent > 0). Use a positive radius.");
  if (shape.kind == ShapeKind::capsule && (!(shape.length_m >= 0.0) || !std::isfinite(shape.length_m)))
    reject(body,
           "length_m " + rounded_text(shape.length_m) + " (the cylinder part cannot be negative). Use 0 or more.");
  if (shape.kind == ShapeKind::cylinder && !is_positive(shape.length_m))
    reject(body,
           "length_m " + rounded_text(shape.length_m) + " (a shape needs a finite extent > 0). Use a positive length.");
  if ((shape.kind == ShapeKind::ellipsoid || shape.kind == ShapeKind::box) &&
      !(shape.extents_m.minCoeff() > 0.0 && shape.extents_m.allFinite()))
    reject(body, "its extents are not all positive (a shape needs finite extents > 0). Use positive lengths.");
  if (shape.kind == ShapeKind::mesh && (shape.mesh == nullptr || !is_positive(make_solid(shape)->moments().volume)))
    reject(body, "its mesh encloses no volume (it is empty, open or inside out). Use a closed mesh.");
  if (shape.kind == ShapeKind::compound && shape.parts.empty())
    reject(body, "it has no parts (a compound needs one). Add a part.");
  for (const ShapePart& part : shape.parts) check_shape(body, part.shape);
}

/// Of a rigid body each principal moment is positive, and none is larger than the sum of the others.
void check_inertia(const BodySpecification& body) {
  if (body.inertia_kg_m2.empty()) return;
  if (body.inertia_kg_m2.size() == 6) {
    const Eigen::Matrix3d tensor = inertia_tensor_kg_m2(body);
    constexpr double rounding = 1e-9;
    if (tensor.allFinite()) {
      const Eigen::Vector3d moments = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(tensor).eigenvalues();
      if (moments[0] > 0.0 && moments[0] + moments[1] >= (1.0 - rounding) * moments[2]) return;
    }
  }
  reject(body,
         "inertia_kg_m2 is not that of a rigid body (six numbers xx, yy, zz, xy, xz, yz; principal moments are "
         "positive, none larger than the sum of the other two). Correct it, or leave it out.");
}

void check(const BodySpecification& body) {
  if (!is_positive(body.mass_kg))
    reject(body, "mass_kg " + rounded_text(body.mass_kg) + " (a body needs a finite mass > 0). Use a positive mass.");
  check_shape(body, body.shape);
  check_inertia(body);
  if (!(std::abs(body.orientation_wxyz.norm() - 1.0) < 1e-6))
    reject(body, "orientation_wxyz has norm " + rounded_text(body.orientation_wxyz.norm()) +
                     " (a rotation is a unit quaternion). Divide it by its norm.");
  if (!body.position_m.allFinite() || !body.velocity_m_per_s.allFinite() ||
      !body.angular_velocity_rad_per_s.allFinite())
    reject(body, "its initial state is not finite (a number is inf or NaN). Use finite numbers.");
  if (body.motion > MotionKind::axis)
    reject(body, "unknown kind of motion (the setup holds no valid value). Use free, fixed, prescribed or axis.");
  if (body.motion == MotionKind::axis && !(std::abs(body.axis.norm() - 1.0) < 1e-6))
    reject(body, "its axis has length " + rounded_text(body.axis.norm()) +
                     " (a direction is a unit vector). Divide it by its length.");
}

/// An initial velocity, brought into line with the body's kind of motion: along the axis for `axis`.
/// @param key  of the velocity, for the error
/// @throws CaseError if it is that of a fixed body, or off the axis
Eigen::Vector3d constrained(const BodySpecification& body, const Eigen::Vector3d& velocity, const char* key) {
  if (body.motion == MotionKind::fixed && !velocity.isZero(0.0))
    reject(body, "a velocity is given (motion: fixed never moves). Remove the velocity or use motion: prescribed.");
  if (body.motion != MotionKind::axis) return velocity;
  constexpr double rounding = 1e-9;  // of the case's numbers
  const Eigen::Vector3d axis = body.axis.normalized();
  Eigen::Vector3d part = axis * axis.dot(velocity);
  if ((velocity - part).norm() > rounding * velocity.norm())
    reject(body, std::string(key) +
                     " points off its axis (motion: axis moves along, and turns about, the axis only). Give a "
                     "velocity along the axis or use motion: free.");
  return part;
}

/// Inverse of the inertia with which the body answers to torques, see MotionState.
Eigen::Matrix3d inverse_inertia(const BodySpecification& body, const Eigen::Vector4d& q_WB) {
  const Eigen::Matrix3d inertia_B = inertia_tensor_kg_m2(body);
  if (body.motion == MotionKind::free)  // of a diagonal one the reciprocals
    return inertia_B.ldlt().solve(Eigen::Matrix3d::Identity());
  if (body.motion != MotionKind::axis) return Eigen::Matrix3d::Identity();
  // Turning about an axis through the centre of mass does not change aᵀ I a: one number serves for the whole run.
  const Eigen::Vector3d axis_B = rotation_matrix(q_WB).transpose() * body.axis.normalized();
  return Eigen::Matrix3d::Identity() * (1.0 / axis_B.dot(inertia_B * axis_B));
}

}  // namespace

BodyModel::BodyModel(const BodySetup& setup) {
  const auto bodies = static_cast<Eigen::Index>(setup.bodies.size());
  axis_.resize(3, bodies);
  inverse_mass_per_kg_.resize(bodies);
  inverse_inertia_.resize(3, bodies);
  initial_.resize(bodies);
  for (Eigen::Index body = 0; body < bodies; ++body) add(body, setup.bodies[body]);
}

void BodyModel::add(Eigen::Index body, const BodySpecification& specification) {
  check(specification);
  const Eigen::Vector4d q_WB = specification.orientation_wxyz.normalized();

  names_.push_back(specification.name);
  shapes_.push_back(specification.shape);
  motions_.push_back(specification.motion);
  axis_.col(body) = specification.axis.normalized();
  inverse_mass_per_kg_[body] = 1.0 / specification.mass_kg;
  full_.push_back(inverse_inertia(specification, q_WB));
  inverse_inertia_.col(body) = full_.back().diagonal();
  inertia_.push_back(!full_.back().isDiagonal(0.0)                                             ? Inertia::full
                     : (inverse_inertia_.col(body).array() == inverse_inertia_(0, body)).all() ? Inertia::isotropic
                                                                                               : Inertia::principal);

  initial_.position_m.col(body) = specification.position_m;
  initial_.orientation_wxyz.col(body) = q_WB;
  initial_.velocity_m_per_s.col(body) = constrained(specification, specification.velocity_m_per_s, "velocity_m_per_s");
  const Eigen::Matrix3d R_WB =
      inertia_[body] == Inertia::isotropic ? Eigen::Matrix3d::Identity() : rotation_matrix(q_WB);
  const Eigen::Vector3d w_W =
      constrained(specification, specification.angular_velocity_rad_per_s, "angular_velocity_rad_per_s");
  const Eigen::Vector3d w_B = R_WB.transpose() * w_W;
  initial_.angular_momentum_N_m_s.col(body) = R_WB * full_.back().ldlt().solve(w_B);
}

}  // namespace copepod::body
