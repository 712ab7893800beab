#include "forces/bends.hpp"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "contract/number_text.hpp"

namespace copepod::body {

namespace {

void check(const BendSpecification& bend, std::size_t index, int bodies) {
  const std::string name = "bend " + std::to_string(index);
  const auto exists = [bodies](int body) { return body >= 0 && body < bodies; };
  const bool three = bend.body_A != bend.body_B && bend.body_B != bend.body_C && bend.body_C != bend.body_A;
  if (!three || !exists(bend.body_A) || !exists(bend.body_B) || !exists(bend.body_C)) {
    throw CaseError(name + " joins bodies " + std::to_string(bend.body_A) + ", " + std::to_string(bend.body_B) +
                    " and " + std::to_string(bend.body_C) + " (it needs three of the " + std::to_string(bodies) +
                    " bodies, counted from 0). Correct the indices.");
  }
  if (!(bend.stiffness_N_m_per_rad >= 0.0)) {
    throw CaseError(name + " has a negative stiffness (it must not create energy). Use 0 or more.");
  }
  if (!(bend.rest_angle_rad >= 0.0 && bend.rest_angle_rad <= std::numbers::pi)) {
    throw CaseError(name + " has a rest angle of " + rounded_text(bend.rest_angle_rad) +
                    " rad (the angle between two arms is between 0 and pi). Use such an angle.");
  }
}

}  // namespace

Bends::Bends(const BodySetup& setup) : bends_(setup.bends) {
  for (const auto& body : setup.bodies) names_.push_back(body.name);
  for (std::size_t i = 0; i < bends_.size(); ++i) check(bends_[i], i, static_cast<int>(names_.size()));
}

void Bends::add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors&) const {
  const BlockVectors& position_m = stage.state.position_m;
  for (const int index : stage.block.bends) {
    const BendSpecification& bend = bends_[static_cast<std::size_t>(index)];
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

}  // namespace copepod::body
