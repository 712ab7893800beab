#pragma once

#include <vector>

#include "contract/body_setup.hpp"
#include "forces/force_element.hpp"

namespace copepod::body {

/// The drive: all actuators of a case, along their current directions.
class Actuators final : public ForceElement {
 public:
  /// @throws CaseError if an actuator is on bodies that do not exist, or a pair on one body, or a direction is not a
  ///         unit vector
  explicit Actuators(const BodySetup& setup);

  /// Adds the loads actuator by actuator, in the order of the setup.
  /// @throws SolverError if the ends of a pair coincide
  void add_loads(const Stage& stage, BlockVectors& force_N, BlockVectors& torque_N_m) const override;

 private:
  std::vector<ActuatorSpecification> actuators_;
};

}  // namespace copepod::body
