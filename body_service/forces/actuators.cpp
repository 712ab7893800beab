#include "forces/actuators.hpp"

#include <cmath>
#include <string>

#include "contract/errors.hpp"
#include "contract/words.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::body {

Actuators::Actuators(const BodySetup& setup) : actuators_(setup.actuators) {
  const auto exists = [&](int body) { return body >= 0 && body < static_cast<int>(setup.bodies.size()); };
  for (std::size_t i = 0; i < setup.actuators.size(); ++i) {
    const ActuatorSpecification& actuator = setup.actuators[i];
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
