#include "model/exits.hpp"

#include <algorithm>
#include <set>

namespace copepod::body {

namespace {

double height_m(const WallSpecification& exit, const Eigen::Vector3d& at_m) {
  return exit.normal.dot(at_m - exit.point_m);
}

std::set<int> held(const BodySetup& setup) {
  std::set<int> bodies;
  for (const SpringSpecification& spring : setup.springs) bodies.insert({spring.body_A, spring.body_B});
  for (const BendSpecification& bend : setup.bends) bodies.insert({bend.body_A, bend.body_B, bend.body_C});
  for (const JointSpecification& joint : setup.joints) bodies.insert({joint.body_A, joint.body_B});
  for (const ActuatorSpecification& actuator : setup.actuators) bodies.insert({actuator.body_A, actuator.body_B});
  return bodies;
}

}  // namespace

Exits::Exits(const BodySetup& setup, const BodyModel& model) {
  for (const WallSpecification& wall : setup.walls)
    if (wall.removes_bodies) exits_.push_back(wall);
  if (exits_.empty()) return;
  double spacing_m = 0.0;
  for (const Shape& shape : model.shapes()) spacing_m = std::max(spacing_m, 4.0 * bounding_radius_m(shape));
  const std::set<int> held_bodies = held(setup);
  for (Eigen::Index body = 0; body < model.bodies(); ++body)
    if (model.motion(body) != MotionKind::fixed && !held_bodies.contains(static_cast<int>(body)))
      free_to_go_.push_back(
          {body, bounding_radius_m(model.shape(body)), spacing_m * static_cast<double>(free_to_go_.size() + 1)});
}

void Exits::remove_bodies(const Eigen::Matrix3Xd& before_m, MotionState& state) const {
  for (const FreeToGo& each : free_to_go_) {
    const Eigen::Index body = each.body;
    auto position_m = state.position_m.col(body);
    const auto was_removed = [&](const WallSpecification& exit) { return height_m(exit, before_m.col(body)) < 0.0; };
    if (std::ranges::any_of(exits_, was_removed)) {
      position_m = before_m.col(body);
      state.velocity_m_per_s.col(body).setZero();
    } else {
      const auto reached = [&](const WallSpecification& exit) { return height_m(exit, position_m) <= each.radius_m; };
      const auto exit = std::ranges::find_if(exits_, reached);
      if (exit == exits_.end()) continue;
      position_m -= (height_m(*exit, position_m) + each.depth_m) * exit->normal;
    }
    state.angular_momentum_N_m_s.col(body).setZero();
  }
}

}  // namespace copepod::body
