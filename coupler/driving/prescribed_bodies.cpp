#include "driving/prescribed_bodies.hpp"

#include <algorithm>
#include <utility>

#include "contract/errors.hpp"
#include "contract/features.hpp"
#include "geometry/actuator_loads.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {

namespace {

std::vector<Eigen::Index> all_but(const std::vector<PrescribedBody>& prescribed, std::size_t bodies) {
  std::vector<Eigen::Index> left;
  for (Eigen::Index body = 0; body < static_cast<Eigen::Index>(bodies); ++body) {
    if (std::ranges::find(prescribed, body, &PrescribedBody::body) == prescribed.end()) left.push_back(body);
  }
  return left;
}

std::vector<Shape> shapes_of(const std::vector<BodySpecification>& bodies) {
  std::vector<Shape> shapes;
  shapes.reserve(bodies.size());
  for (const BodySpecification& body : bodies) shapes.push_back(body.shape);
  return shapes;
}

}  // namespace

void take_out(const std::vector<PrescribedBody>& prescribed, BodySetup& setup) {
  if (prescribed.empty()) return;
  std::vector<int> number(setup.bodies.size(), -1);
  std::vector<BodySpecification> left;
  for (const Eigen::Index body : all_but(prescribed, setup.bodies.size())) {
    number[body] = static_cast<int>(left.size());
    left.push_back(std::move(setup.bodies[body]));
  }
  setup.bodies = std::move(left);
  const auto renumber = [&number](int& body) {
    if (body >= 0) body = number[body];
  };
  for (SpringSpecification& spring : setup.springs)
    for (int* body : {&spring.body_A, &spring.body_B}) renumber(*body);
  for (BendSpecification& bend : setup.bends)
    for (int* body : {&bend.body_A, &bend.body_B, &bend.body_C}) renumber(*body);
  for (JointSpecification& joint : setup.joints)
    for (int* body : {&joint.body_A, &joint.body_B}) renumber(*body);
  for (ActuatorSpecification& actuator : setup.actuators)
    for (int* body : {&actuator.body_A, &actuator.body_B}) renumber(*body);
}

PrescribedBodies::PrescribedBodies(std::unique_ptr<BodySolver> others, const std::vector<BodySpecification>& bodies,
                                   const std::vector<PrescribedBody>& prescribed, DrivingProtocol& driving,
                                   const BodySetup& setup)
    : others_(std::move(others)),
      bodies_(bodies),
      free_(all_but(prescribed, bodies.size())),
      driving_(driving),
      step_s_(setup.step_s),
      overlaps_(shapes_of(bodies), {setup.periodic_length_m}) {
  for (const PrescribedBody& each : prescribed) prescribed_.push_back(each.body);
}

void PrescribedBodies::kinematics(Kinematics& kinematics) {
  others_->kinematics(others_kinematics_);
  complete(kinematics);
}

void PrescribedBodies::step(const AppliedLoads& applied, Kinematics& next) {
  others_applied_.hydrodynamic.step = applied.hydrodynamic.step;
  others_applied_.hydrodynamic.force_N = applied.hydrodynamic.force_N(Eigen::all, free_);
  others_applied_.hydrodynamic.torque_N_m = applied.hydrodynamic.torque_N_m(Eigen::all, free_);
  others_applied_.actuation = applied.actuation;
  others_->step(others_applied_, others_kinematics_);
  complete(next);
  check_overlaps(next);
}

void PrescribedBodies::complete(Kinematics& kinematics) {
  const std::int64_t step = others_kinematics_.step;
  kinematics.step = step;
  kinematics.resize(bodies_.size());
  kinematics.position_m(Eigen::all, free_) = others_kinematics_.position_m;
  kinematics.orientation_wxyz(Eigen::all, free_) = others_kinematics_.orientation_wxyz;
  kinematics.velocity_m_per_s(Eigen::all, free_) = others_kinematics_.velocity_m_per_s;
  kinematics.angular_velocity_rad_per_s(Eigen::all, free_) = others_kinematics_.angular_velocity_rad_per_s;
  for (std::size_t i = 0; i < prescribed_.size(); ++i) {
    const Eigen::Index number = prescribed_[i];
    const BodySpecification& body = bodies_[number];
    const auto [factor, way_steps] = driving_.prescribed(i, step);
    const double time_s = way_steps * step_s_;
    kinematics.position_m.col(number) = body.position_m + time_s * body.velocity_m_per_s;
    kinematics.orientation_wxyz.col(number) = rotated(time_s * body.angular_velocity_rad_per_s, body.orientation_wxyz);
    kinematics.velocity_m_per_s.col(number) = factor * body.velocity_m_per_s;
    kinematics.angular_velocity_rad_per_s.col(number) = factor * body.angular_velocity_rad_per_s;
  }
}

void PrescribedBodies::check_overlaps(const Kinematics& kinematics) const {
  for (const Eigen::Index prescribed : prescribed_) {
    const BodySpecification& A = bodies_[prescribed];
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const BodySpecification& B = bodies_[b];
      if (&A == &B || !(overlaps_.depth_m(static_cast<int>(prescribed), static_cast<int>(b), kinematics.position_m,
                                          kinematics.orientation_wxyz) > 0.0))
        continue;
      throw SolverError("body '" + A.name + "' met body '" + B.name +
                            "' (the motion of the first is prescribed, and it pushes no other). Prescribe another "
                            "motion, or start them further apart.",
                        0, kinematics.step);
    }
  }
}

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
  applied_.actuation.resize(lowered_.size(), applied.actuation.cols());
  for (Eigen::Index node = 0; node < applied.actuation.cols(); ++node) {
    drive_loads(actuators_, applied.actuation.col(node), start_, drive_);
    for (std::size_t i = 0; i < lowered_.size(); ++i) {
      const auto& loads = lowered_[i].kind == ActuatorKind::world_force ? drive_.force_N : drive_.torque_N_m;
      applied_.actuation(i, node) = lowered_[i].direction.dot(loads.col(lowered_[i].body_A));
    }
  }
  solver_->step(applied_, next);
  start_ = next;
}

}  // namespace copepod::coupler
