#include "forces/springs.hpp"

#include <Eigen/Geometry>

#include "contract/errors.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {

namespace {

void check(const SpringSpecification& spring, std::size_t index, int bodies) {
  const std::string name = "spring " + std::to_string(index);
  const auto exists = [bodies](int body) { return body >= 0 && body < bodies; };
  if (!exists(spring.body_A) || !exists(spring.body_B)) {
    throw CaseError(name + " connects bodies " + std::to_string(spring.body_A) + " and " +
                    std::to_string(spring.body_B) + " (there are " + std::to_string(bodies) +
                    " bodies, counted from 0). Correct the indices.");
  }
  if (spring.body_A == spring.body_B) {
    throw CaseError(name + " connects body " + std::to_string(spring.body_A) +
                    " to itself (such a spring does no work). Connect two bodies.");
  }
  if (!(spring.stiffness_N_per_m >= 0.0) || !(spring.damping_N_s_per_m >= 0.0) || !(spring.rest_length_m >= 0.0)) {
    throw CaseError(name +
                    " has a negative stiffness, damping or rest length (a spring must not create energy, and a length "
                    "is not negative). Use 0 or more.");
  }
}

}  // namespace

Springs::Springs(const BodySetup& setup) {
  for (const auto& body : setup.bodies) names_.push_back(body.name);
  for (const auto& spring : setup.springs) {
    check(spring, springs_.size(), static_cast<int>(setup.bodies.size()));
    springs_.push_back({spring.body_A,
                        spring.body_B,
                        {spring.stiffness_N_per_m, spring.damping_N_s_per_m, spring.rest_length_m},
                        !spring.anchor_A_m.isZero(0.0) || !spring.anchor_B_m.isZero(0.0),
                        spring.anchor_A_m,
                        spring.anchor_B_m});
  }
}

void Springs::add_loads(const Stage& stage, Eigen::Matrix3Xd& force_N, Eigen::Matrix3Xd& torque_N_m) const {
  const MotionState& state = stage.state;
  const Eigen::Index first = stage.block.first;
  for (const int index : stage.block.springs) {
    const Spring& spring = springs_[index];
    const Eigen::Index A = spring.body_A - first;
    const Eigen::Index B = spring.body_B - first;
    if (!spring.anchored) {
      const Eigen::Vector3d f_A_W_N = force_of(spring, state.position_m.col(B) - state.position_m.col(A),
                                               state.velocity_m_per_s.col(B) - state.velocity_m_per_s.col(A));
      force_N.col(A) += f_A_W_N;
      force_N.col(B) -= f_A_W_N;
      continue;
    }
    const Pull anchored = pull(static_cast<std::size_t>(index), first, state, stage.angular_velocity_rad_per_s);
    force_N.col(A) += anchored.f_A_W_N;
    force_N.col(B) -= anchored.f_A_W_N;
    torque_N_m.col(A) += anchored.r_A_W_m.cross(anchored.f_A_W_N);
    torque_N_m.col(B) -= anchored.r_B_W_m.cross(anchored.f_A_W_N);
  }
}

Springs::Pull Springs::pull(std::size_t index, Eigen::Index first, const MotionState& state,
                            const Eigen::Matrix3Xd& w) const {
  const Spring& spring = springs_[index];
  const Eigen::Index A = spring.body_A - first;
  const Eigen::Index B = spring.body_B - first;
  Pull pull;
  pull.r_A_W_m = rotation_matrix(state.orientation_wxyz.col(A)) * spring.anchor_A_m;
  pull.r_B_W_m = rotation_matrix(state.orientation_wxyz.col(B)) * spring.anchor_B_m;
  pull.d_AB_W_m = (state.position_m.col(B) - state.position_m.col(A)) + (pull.r_B_W_m - pull.r_A_W_m);
  const Eigen::Vector3d ddot_AB_W_m_per_s = (state.velocity_m_per_s.col(B) + w.col(B).cross(pull.r_B_W_m)) -
                                            (state.velocity_m_per_s.col(A) + w.col(A).cross(pull.r_A_W_m));
  pull.f_A_W_N = force_of(spring, pull.d_AB_W_m, ddot_AB_W_m_per_s);
  return pull;
}

Eigen::Vector3d Springs::force_of(const Spring& spring, const Eigen::Vector3d& d_AB_W_m,
                                  const Eigen::Vector3d& ddot_AB_W_m_per_s) const {
  if (d_AB_W_m.isZero(0.0)) {
    throw SolverError("the ends of the spring between bodies '" + names_[spring.body_A] + "' and '" +
                      names_[spring.body_B] +
                      "' coincide (its force has no direction). Give it a longer rest "
                      "length, a higher stiffness, or start its ends apart.");
  }
  return spring_force(spring.law, d_AB_W_m, ddot_AB_W_m_per_s);
}

}  // namespace copepod::body
