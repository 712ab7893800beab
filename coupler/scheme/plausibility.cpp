#include "scheme/plausibility.hpp"

#include <cmath>
#include <string>

#include "contract/errors.hpp"
#include "contract/number_text.hpp"

namespace copepod::coupler {
namespace {

constexpr std::array axes{"x", "y", "z"};
constexpr double quaternion_tolerance = 1e-3;
constexpr double largest_turn_rad = 1.0;  // the surface then moves by a radius

[[noreturn]] void fail(const BodySpecification& body, std::int64_t step, const std::string& found) {
  throw PeerFailed({ExitCode::solver_failed, "body", "", 0, step,
                    "In step " + std::to_string(step) + " body '" + body.name + "' " + found +
                        ". Use a smaller step, smaller forces, coupling.virtual_mass: auto for light bodies, or check "
                        "the body component."});
}

}  // namespace

Plausibility::Plausibility(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies,
                           double largest_speed_m_per_s)
    : bodies_(bodies), largest_speed_m_per_s_(largest_speed_m_per_s) {
  confined_.resize(bodies.size());
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<Eigen::Index>(axis);
    length_m_[i] = static_cast<double>(fluid.domain_cells[axis]) * fluid.cell_size_m;
    periodic_[axis] = length_m_[i] > 0.0 && fluid.boundaries[2 * axis].kind == BoundaryKind::periodic;
    if (periodic_[axis]) continue;
    for (std::size_t body = 0; body < bodies.size(); ++body) {
      const double at = bodies[body].position_m[i];
      confined_[body][axis] = length_m_[i] > 0.0 && at >= 0.0 && at <= length_m_[i];
    }
  }
}

void Plausibility::judge(const Kinematics& before, const Kinematics& after) const {
  if (after.bodies() != static_cast<Eigen::Index>(bodies_.size())) {
    throw PeerFailed({ExitCode::solver_failed, "body", "", 0, before.step,
                      "The body component returned " + std::to_string(after.bodies()) + " bodies in step " +
                          std::to_string(before.step) + " (the case has " + std::to_string(bodies_.size()) +
                          "). Fix its step()."});
  }
  // Written so that a comparison with NaN fails.
  for (Eigen::Index column = 0; column < after.bodies(); ++column) {
    const BodySpecification& body = bodies_[static_cast<std::size_t>(column)];
    const double norm = after.orientation_wxyz.col(column).norm();
    if (!(std::abs(norm - 1.0) <= quaternion_tolerance)) {
      fail(body, before.step,
           "got an orientation of length " + rounded_text(norm) + " (an orientation is a quaternion of length 1)");
    }
    Eigen::Vector3d moved = after.position_m.col(column) - before.position_m.col(column);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      const double at = after.position_m(axis, column);
      if (periodic_[i]) {  // a component may fold positions back into the domain
        moved[axis] -= length_m_[axis] * std::round(moved[axis] / length_m_[axis]);
      } else if (confined_[static_cast<std::size_t>(column)][i] && !(at >= 0.0 && at <= length_m_[axis])) {
        fail(body, before.step,
             std::string("left the domain: ") + axes[i] + " = " + length_text(at) + " (the domain ends at 0 and " +
                 length_text(length_m_[axis]) + ")");
      }
    }
    const double distance = moved.norm();
    if (!(distance <= body.shape.radius_m)) {
      fail(body, before.step,
           "moved by " + length_text(distance) + " (more than its radius of " + length_text(body.shape.radius_m) + ")");
    }
    const double half_turn = std::abs(after.orientation_wxyz.col(column).dot(before.orientation_wxyz.col(column)));
    if (!(half_turn >= std::cos(0.5 * largest_turn_rad) * (1.0 - 2.0 * quaternion_tolerance)))
      fail(body, before.step, "turned by more than one radian");
    const double speed_m_per_s = after.velocity_m_per_s.col(column).norm() +
                                 after.angular_velocity_rad_per_s.col(column).norm() * bounding_radius_m(body.shape);
    if (!(speed_m_per_s <= largest_speed_m_per_s_) || !std::isfinite(speed_m_per_s)) {
      fail(body, before.step,
           "has a surface that moves at " + rounded_text(speed_m_per_s) + " m/s (the fluid follows up to " +
               rounded_text(largest_speed_m_per_s_) + " m/s: the coupling has diverged)");
    }
  }
}

}  // namespace copepod::coupler
