#include "forces/forces.hpp"

#include <algorithm>
#include <numbers>
#include <set>

#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/actuator_loads.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {

namespace {

void check(const SpringSpecification& spring, std::size_t index, int bodies) {
  const std::string name = "spring " + std::to_string(index);
  if (std::min(spring.body_A, spring.body_B) < 0 || std::max(spring.body_A, spring.body_B) >= bodies)
    throw CaseError(name + " connects bodies " + std::to_string(spring.body_A) + " and " +
                    std::to_string(spring.body_B) + " (there are " + std::to_string(bodies) +
                    " bodies, counted from 0). Correct the indices.");
  if (spring.body_A == spring.body_B)
    throw CaseError(name + " connects body " + std::to_string(spring.body_A) +
                    " to itself (such a spring does no work). Connect two bodies.");
  if (!(spring.stiffness_N_per_m >= 0.0) || !(spring.damping_N_s_per_m >= 0.0) || !(spring.rest_length_m >= 0.0))
    throw CaseError(name +
                    " has a negative stiffness, damping or rest length (a spring must not create energy, and a length "
                    "is not negative). Use 0 or more.");
}

void check(const BendSpecification& bend, std::size_t index, int bodies) {
  const std::string name = "bend " + std::to_string(index);
  const std::set three{bend.body_A, bend.body_B, bend.body_C};
  if (three.size() < 3 || *three.begin() < 0 || *three.rbegin() >= bodies)
    throw CaseError(name + " joins bodies " + std::to_string(bend.body_A) + ", " + std::to_string(bend.body_B) +
                    " and " + std::to_string(bend.body_C) + " (it needs three of the " + std::to_string(bodies) +
                    " bodies, counted from 0). Correct the indices.");
  if (!(bend.stiffness_N_m_per_rad >= 0.0))
    throw CaseError(name + " has a negative stiffness (it must not create energy). Use 0 or more.");
  if (!(bend.rest_angle_rad >= 0.0 && bend.rest_angle_rad <= std::numbers::pi))
    throw CaseError(name + " has a rest angle of " + rounded_text(bend.rest_angle_rad) +
                    " rad (the angle between two arms is between 0 and pi). Use such an angle.");
}

}  // namespace

Springs::Springs(const BodySetup& setup) : springs_(setup.springs) {
  for (const auto& body : setup.bodies) names_.push_back(body.name);
  for (std::size_t i = 0; i < springs_.size(); ++i) check(springs_[i], i, static_cast<int>(names_.size()));
}

void Springs::add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const {
  const BodyBlock& block = stage.block;
  const auto v = components(stage.state.velocity_m_per_s);
  const auto [e_x, e_y, e_z] = components(stage.lines.direction);
  const auto force = components(force_N);
  for (std::size_t i = 0; i < block.springs.size(); ++i) {
    const auto index = static_cast<std::size_t>(block.springs[i]);
    const int line = block.spring_lines[i];
    if (line < 0) {
      add_anchored(index, stage, force_N, torque_N_m);
      continue;
    }
    const SpringSpecification& spring = springs_[index];
    const double length_m = stage.lines.length_m[line];
    if (length_m == 0.0) fail(spring);
    const std::array<int, 2>& ends = block.lines[line];
    const auto [A, B] = ends;
    const std::array e{e_x[line], e_y[line], e_z[line]};
    const std::array ddot_AB_m_per_s{v[0][B] - v[0][A], v[1][B] - v[1][A], v[2][B] - v[2][A]};
    pull_together(ends, tension_N(spring, length_m, e, ddot_AB_m_per_s), e, force);
  }
}

void Springs::add_anchored(std::size_t index, const Stage& stage, BlockVectors& force_N,
                           BlockVectors& torque_N_m) const {
  const Eigen::Index A = springs_[index].body_A - stage.block.first;
  const Eigen::Index B = springs_[index].body_B - stage.block.first;
  const Pull anchored = pull(index, stage.block.first, stage.state, stage.angular_velocity_rad_per_s);
  force_N.col(A) += anchored.f_A_W_N;
  force_N.col(B) -= anchored.f_A_W_N;
  torque_N_m.col(A) += anchored.r_A_W_m.cross(anchored.f_A_W_N);
  torque_N_m.col(B) -= anchored.r_B_W_m.cross(anchored.f_A_W_N);
}

Springs::Pull Springs::pull(std::size_t index, Eigen::Index first, const BlockState& state,
                            const BlockVectors& w) const {
  const SpringSpecification& spring = springs_[index];
  const Eigen::Index A = spring.body_A - first;
  const Eigen::Index B = spring.body_B - first;
  Pull pull;
  pull.r_A_W_m = rotation_matrix(state.orientation_wxyz.col(A)) * spring.anchor_A_m;
  pull.r_B_W_m = rotation_matrix(state.orientation_wxyz.col(B)) * spring.anchor_B_m;
  pull.d_AB_W_m = (state.position_m.col(B) - state.position_m.col(A)) + (pull.r_B_W_m - pull.r_A_W_m);
  const Eigen::Vector3d ddot_AB_W_m_per_s = (state.velocity_m_per_s.col(B) + w.col(B).cross(pull.r_B_W_m)) -
                                            (state.velocity_m_per_s.col(A) + w.col(A).cross(pull.r_A_W_m));
  if (pull.d_AB_W_m.isZero(0.0)) fail(spring);
  pull.f_A_W_N = spring_force(spring, pull.d_AB_W_m, ddot_AB_W_m_per_s);
  return pull;
}

void Springs::fail(const SpringSpecification& spring) const {
  throw SolverError("the ends of the spring between bodies '" + names_[spring.body_A] + "' and '" +
                    names_[spring.body_B] +
                    "' coincide (its force has no direction). Give it a longer rest length, a higher stiffness, or "
                    "start its ends apart.");
}

Bends::Bends(const BodySetup& setup) : bends_(setup.bends) {
  for (const auto& body : setup.bodies) names_.push_back(body.name);
  for (std::size_t i = 0; i < bends_.size(); ++i) check(bends_[i], i, static_cast<int>(names_.size()));
}

void Bends::add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors&) const {
  const BlockVectors& position_m = stage.state.position_m;
  for (const int index : stage.block.bends) {
    const BendSpecification& bend = bends_[index];
    const Eigen::Index A = bend.body_A - stage.block.first;
    const Eigen::Index B = bend.body_B - stage.block.first;
    const Eigen::Index C = bend.body_C - stage.block.first;
    const Eigen::Vector3d a_W_m = position_m.col(A) - position_m.col(B);
    const Eigen::Vector3d c_W_m = position_m.col(C) - position_m.col(B);
    const double length_a_m = a_W_m.norm();
    const double length_c_m = c_W_m.norm();
    if (length_a_m == 0.0 || length_c_m == 0.0) fail(bend);
    const Eigen::Vector3d a = a_W_m / length_a_m;
    const Eigen::Vector3d c = c_W_m / length_c_m;
    const double sine = a.cross(c).norm();
    // π − θ instead of θ: nearly straight arms then lose no digits.
    const double excess_rad = (std::numbers::pi - bend.rest_angle_rad) - std::atan2(sine, -a.dot(c));
    // Of parallel arms the rounding errors would be the direction.
    if (sine < 1e-12 && std::abs(excess_rad) > 1e-9) fail(bend);
    if (sine == 0.0) continue;
    const double moment_N_m = bend.stiffness_N_m_per_rad * excess_rad / sine;
    const Eigen::Vector3d f_A_W_N = moment_N_m / length_a_m * (c - c.dot(a) * a);
    const Eigen::Vector3d f_C_W_N = moment_N_m / length_c_m * (a - a.dot(c) * c);
    force_N.col(A) += f_A_W_N;
    force_N.col(C) += f_C_W_N;
    force_N.col(B) -= f_A_W_N + f_C_W_N;
  }
}

void Bends::fail(const BendSpecification& bend) const {
  throw SolverError("the arms of the bend at '" + names_[bend.body_B] + "' to '" + names_[bend.body_A] + "' and '" +
                    names_[bend.body_C] +
                    "' are parallel or of no length (its forces have no direction). Start at another angle, or use a "
                    "rest angle of pi for straight arms.");
}

Actuators::Actuators(const BodySetup& setup) : actuators_(setup.actuators) {
  const auto exists = [&](int body) { return body >= 0 && body < static_cast<int>(setup.bodies.size()); };
  for (std::size_t i = 0; i < setup.actuators.size(); ++i) {
    const ActuatorSpecification& actuator = setup.actuators[i];
    const std::string name = "actuator " + std::to_string(i);
    const bool pair = actuator.kind == ActuatorKind::pair_force;
    if (!exists(actuator.body_A) || (pair && (!exists(actuator.body_B) || actuator.body_A == actuator.body_B)))
      throw CaseError(name + " is on bodies " + std::to_string(actuator.body_A) + " and " +
                      std::to_string(actuator.body_B) + " (there are " + std::to_string(setup.bodies.size()) +
                      " bodies, counted from 0, and a pair needs two). Correct the indices.");
    if (!pair && !(std::abs(actuator.direction.norm() - 1.0) < 1e-6))
      throw CaseError(name + " has a direction of length " + rounded_text(actuator.direction.norm()) +
                      " (it must be a unit vector). Divide it by its norm.");
  }
}

void Actuators::add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const {
  const BodyBlock& block = stage.block;
  const auto [e_x, e_y, e_z] = components(stage.lines.direction);
  const auto force = components(force_N);
  for (std::size_t i = 0; i < block.actuators.size(); ++i) {
    const int index = block.actuators[i];
    const int line = block.actuator_lines[i];
    const double value = stage.actuation[index];
    if (value == 0.0) continue;
    if (line < 0) {
      add_actuator_loads(actuators_[index], value, block.first, stage.state.position_m, stage.state.orientation_wxyz,
                         force_N, torque_N_m);
      continue;
    }
    const std::array<int, 2>& ends = block.lines[line];
    if (stage.lines.length_m[line] == 0.0)
      throw coinciding_ends(static_cast<int>(block.first) + ends[0], static_cast<int>(block.first) + ends[1]);
    pull_together(ends, -value, std::array{e_x[line], e_y[line], e_z[line]}, force);
  }
}

}  // namespace copepod::body
