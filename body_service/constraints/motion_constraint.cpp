#include "constraints/motion_constraint.hpp"

#include <cmath>

#include "contract/errors.hpp"
#include "contract/words.hpp"

namespace copepod::body {

namespace {

/// Share of a velocity across the axis that passes for rounding of the case's numbers.
constexpr double off_axis_tolerance = 1e-9;

Eigen::Vector3d along(const BodySpecification& body, const Eigen::Vector3d& velocity, const char* key) {
  const Eigen::Vector3d axis = body.axis.normalized();
  Eigen::Vector3d part = axis * axis.dot(velocity);
  if ((velocity - part).norm() > off_axis_tolerance * velocity.norm()) {
    throw CaseError("body '" + body.name + "': " + key +
                    " points off its axis (motion: axis moves along, and turns about, the axis only). Give a velocity "
                    "along the axis or use motion: free.");
  }
  return part;
}

}  // namespace

BodyVelocities constrained_velocities(const BodySpecification& body) {
  BodyVelocities given{body.velocity_m_per_s, body.angular_velocity_rad_per_s};
  switch (body.motion) {
    case MotionKind::free:
    case MotionKind::prescribed:
      return given;
    case MotionKind::fixed:
      if (!given.linear_m_per_s.isZero(0.0) || !given.angular_rad_per_s.isZero(0.0)) {
        throw CaseError(
            "body '" + body.name +
            "': a velocity is given (motion: fixed never moves). Remove the velocity or use motion: prescribed.");
      }
      return given;
    case MotionKind::axis:
      if (!(std::abs(body.axis.norm() - 1.0) < 1e-6)) {
        throw CaseError("body '" + body.name + "': its axis has length " + rounded_text(body.axis.norm()) +
                        " (a direction is a unit vector). Divide it by its length.");
      }
      return {along(body, given.linear_m_per_s, "velocity_m_per_s"),
              along(body, given.angular_rad_per_s, "angular_velocity_rad_per_s")};
  }
  throw CaseError("body '" + body.name +
                  "': unknown kind of motion (the setup holds no valid value). Use free, fixed, prescribed or axis.");
}

}  // namespace copepod::body
