#include "driving/lowered_bodies.hpp"

#include <algorithm>
#include <utility>

#include "contract/features.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::coupler {

bool must_be_lowered(const std::set<std::string>& required, const std::set<std::string>& announced) {
  if (required.contains("actuator:joint_motion") || required.contains("actuator:control"))
    return false;  // no loads that the coupler could compute
  const auto missing = compare_features(required, announced).missing;
  return (announced.contains("actuator:world_force") || announced.contains("actuator:world_torque")) &&
         std::ranges::any_of(missing, [](const std::string& name) { return name.starts_with("actuator:"); });
}

BodySetup lowered(const BodySetup& setup) {
  std::set<int> pushed, turned;
  for (const ActuatorSpecification& actuator : setup.actuators) {
    const bool pair = actuator.kind == ActuatorKind::pair_force;
    const bool torque = actuator.kind == ActuatorKind::body_torque || actuator.kind == ActuatorKind::world_torque;
    (torque ? turned : pushed).insert(actuator.body_A);
    if (!pair) continue;
    pushed.insert(actuator.body_B);
    if (!actuator.anchor_A_m.isZero(0.0)) turned.insert(actuator.body_A);
    if (!actuator.anchor_B_m.isZero(0.0)) turned.insert(actuator.body_B);
  }
  BodySetup result = setup;
  result.actuators.clear();
  for (const auto& [bodies, kind] :
       {std::pair(pushed, ActuatorKind::world_force), std::pair(turned, ActuatorKind::world_torque)}) {
    for (const int body : bodies) {
      for (int axis = 0; axis < 3; ++axis) result.actuators.push_back({kind, body, -1, Eigen::Vector3d::Unit(axis)});
    }
  }
  return result;
}

LoweredBodies::LoweredBodies(std::unique_ptr<BodySolver> solver, const BodySetup& setup)
    : solver_(std::move(solver)), actuators_(setup.actuators), lowered_(lowered(setup).actuators) {}

void LoweredBodies::kinematics(Kinematics& kinematics) {
  solver_->kinematics(start_);
  kinematics = start_;
}

void LoweredBodies::step(const AppliedLoads& applied, Kinematics& next) {
  applied_.hydrodynamic = applied.hydrodynamic;
  applied_.actuation.resize(static_cast<Eigen::Index>(lowered_.size()), applied.actuation.cols());
  for (Eigen::Index node = 0; node < applied.actuation.cols(); ++node) {
    drive_loads(actuators_, applied.actuation.col(node), start_, drive_);
    for (std::size_t i = 0; i < lowered_.size(); ++i) {
      const auto& loads = lowered_[i].kind == ActuatorKind::world_force ? drive_.force_N : drive_.torque_N_m;
      applied_.actuation(static_cast<Eigen::Index>(i), node) = lowered_[i].direction.dot(loads.col(lowered_[i].body_A));
    }
  }
  solver_->step(applied_, next);
  start_ = next;
}

}  // namespace copepod::coupler
