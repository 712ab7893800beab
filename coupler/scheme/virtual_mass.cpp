#include "scheme/virtual_mass.hpp"

#include <utility>

#include "geometry/rotation.hpp"

namespace copepod::coupler {
namespace {

/// h = R J Rᵀ ω
Eigen::Vector3d angular_momentum(const Eigen::Matrix3d& inertia_kg_m2, const Kinematics& kinematics,
                                 Eigen::Index body) {
  const Eigen::Vector3d w_WB = kinematics.angular_velocity_rad_per_s.col(body);
  if (inertia_kg_m2 == inertia_kg_m2(0, 0) * Eigen::Matrix3d::Identity())  // commutes with every rotation
    return inertia_kg_m2(0, 0) * w_WB;
  const Eigen::Matrix3d R_WB = rotation_matrix(kinematics.orientation_wxyz.col(body));
  return R_WB * (inertia_kg_m2 * (R_WB.transpose() * w_WB));
}

/// The same body with another mass, of the same distribution.
BodySpecification with_mass(BodySpecification body, double mass_kg) {
  for (double& number : body.inertia_kg_m2) number *= mass_kg / body.mass_kg;
  body.mass_kg = mass_kg;
  return body;
}

}  // namespace

VirtualMass::VirtualMass(const BodySetup& setup, const std::vector<double>& mass_kg, LoadAveraging averaging,
                         bool returns)
    : step_s_(setup.step_s), returns_(returns) {
  for (std::size_t body = 0; body < mass_kg.size(); ++body) {
    if (!(mass_kg[body] > 0.0)) continue;
    additions_.push_back({static_cast<Eigen::Index>(body), mass_kg[body],
                          inertia_tensor_kg_m2(with_mass(setup.bodies[body], mass_kg[body])),
                          mass_kg[body] * setup.gravity_m_per_s2});
    if (averaging == LoadAveraging::none) not_averaged_.push_back(additions_.back().body);
  }
}

BodySetup VirtualMass::enlarged(BodySetup setup) const {
  for (const Addition& addition : additions_) {
    BodySpecification& body = setup.bodies[static_cast<std::size_t>(addition.body)];
    body = with_mass(std::move(body), body.mass_kg + addition.mass_kg);
  }
  return setup;
}

void VirtualMass::add_to(Loads& loads, const Kinematics& kinematics) {
  if (!returns_) {
    for (const Addition& addition : additions_) loads.force_N.col(addition.body) -= addition.weight_N;
    return;
  }
  if (additions_.empty()) return;
  if (previous_.bodies() != kinematics.bodies()) previous_ = kinematics;
  for (const auto& [body, mass_kg, inertia_kg_m2, weight_N] : additions_) {
    const Eigen::Vector3d gained_m_per_s = kinematics.velocity_m_per_s.col(body) - previous_.velocity_m_per_s.col(body);
    loads.force_N.col(body) += mass_kg / step_s_ * gained_m_per_s - weight_N;
    loads.torque_N_m.col(body) +=
        (angular_momentum(inertia_kg_m2, kinematics, body) - angular_momentum(inertia_kg_m2, previous_, body)) /
        step_s_;
  }
  previous_ = kinematics;
}

}  // namespace copepod::coupler
