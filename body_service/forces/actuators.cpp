#include "forces/actuators.hpp"

#include <array>
#include <cmath>
#include <string>

#include "contract/errors.hpp"
#include "contract/number_text.hpp"
#include "forces/pair_batch.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::body {

Actuators::Actuators(const BodySetup& setup) {
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
    drives_.push_back({actuator.body_A, actuator.body_B});
    if (pair && actuator.anchor_A_m.isZero(0.0) && actuator.anchor_B_m.isZero(0.0)) continue;
    drives_.back().other = static_cast<int>(others_.size());
    others_.push_back(actuator);
  }
}

void Actuators::add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const {
  const std::vector<int>& actuators = stage.block.actuators;
  for (std::size_t next = 0; next < actuators.size();) {
    const int index = actuators[next];
    const int other = drives_[static_cast<std::size_t>(index)].other;
    if (other < 0) {
      next = add_unanchored(stage, next, force_N);
      continue;
    }
    add_actuator_loads(others_[static_cast<std::size_t>(other)], stage.actuation[index], stage.block.first,
                       stage.state.position_m, stage.state.orientation_wxyz, force_N, torque_N_m);
    ++next;
  }
}

std::size_t Actuators::add_unanchored(const Stage& stage, std::size_t from, BlockVectors& force_N) const {
  PairBatch pairs;
  PairBatch::Numbers values;       // NOLINT(cppcoreguidelines-pro-type-member-init): filled up to pairs.size
  const auto position_m = components(stage.state.position_m);
  const auto first = static_cast<int>(stage.block.first);
  std::size_t next = from;
  for (; next < stage.block.actuators.size() && !pairs.full(); ++next) {
    const int index = stage.block.actuators[next];
    const Drive& drive = drives_[static_cast<std::size_t>(index)];
    if (drive.other >= 0) break;
    const double value = stage.actuation[index];
    if (value == 0.0) continue;
    values[pairs.size] = value;
    pairs.add(drive.body_A - first, drive.body_B - first, position_m);
  }
  for (int pair = 0; pair < pairs.size; ++pair) {
    const auto force_B_N = pair_force(values[pair], PairBatch::at(pairs.d_AB_m, pair));
    for (int i = 0; i < 3; ++i) pairs.force_A_N[i][pair] = -force_B_N[i];
  }
  pairs.add_forces(force_N, [&](int pair) { throw coinciding_ends(first + pairs.ends_A[pair], first + pairs.ends_B[pair]); });
  return next;
}

}  // namespace copepod::body
