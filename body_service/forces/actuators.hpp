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
  struct Drive {
    int body_A = 0;
    int body_B = 0;
    int other = -1;  ///< index in others_; −1: pushes the centres of its bodies apart
  };

  /// The same for pair forces of the block between centres, from number `from` on, as many as fit together.
  /// @return number of the actuator after them
  std::size_t add_unanchored(const Stage& stage, std::size_t from, BlockVectors& force_N) const;

  std::vector<Drive> drives_;
  std::vector<ActuatorSpecification> others_;
};

}  // namespace copepod::body
