#include "forces/actuators.hpp"

#include <cmath>
#include <string>

#include "contract/errors.hpp"
#include "contract/number_text.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::body {

Actuators::Actuators(const BodySetup& setup) : actuators_(setup.actuators) {
  const auto exists = [&](int body) { return body >= 0 && body < static_cast<int>(setup.bodies.size()); };
  for (std::size_t i = 0; i < actuators_.size(); ++i) {
    const ActuatorSpecification& actuator = actuators_[i];
    const std::string name = "actuator " + std::to_string(i);
    const bool pair = actuator.kind == ActuatorKind::pair_force;
    if (!exists(actuator.body_A) || (pair && (!exists(actuator.body_B) || actuator.body_A == actuator.body_B))) {
      throw CaseError(name + " is on bodies " + std::to_string(actuator.body_A) + " and " +
                      std::to_string(actuator.body_B) + " (there are " + std::to_string(setup.bodies.size()) +
                      " bodies, counted from 0, and a pair needs two). Correct the indices.");
    }
    if (!pair && !(std::abs(actuator.direction.norm() - 1.0) < 1e-6)) {
      throw CaseError(name + " has a direction of length " + rounded_text(actuator.direction.norm()) +
                      " (it must be a unit vector). Divide it by its norm.");
    }
  }
}

void Actuators::add_loads(const Stage& stage, Eigen::Matrix3Xd& force_N, Eigen::Matrix3Xd& torque_N_m) const {
  for (const int index : stage.block.actuators) {
    add_actuator_loads(actuators_[static_cast<std::size_t>(index)], stage.actuation[index], stage.block.first,
                       stage.state.position_m, stage.state.orientation_wxyz, force_N, torque_N_m);
  }
}

}  // namespace copepod::body
