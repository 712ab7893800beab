#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "driving/signal.hpp"

namespace copepod::coupler {

/// An actuator and how its value varies.
struct DrivenActuator {
  ActuatorSpecification actuator;
  Signal signal;
};

/// The drive of a case: all actuators, sampled at any place inside a step.
class DrivingProtocol {
 public:
  explicit DrivingProtocol(const std::vector<DrivenActuator>& drive);

  /// Values at times (step + node) of one step; of joints what they have moved since step 0.
  /// @param nodes      fractions of the step
  /// @param actuation  resized to (actuators, nodes) and overwritten
  void sample(std::int64_t step, std::span<const double> nodes, Eigen::MatrixXd& actuation) const;

  /// What the values at the start of a step exert on the bodies.
  /// @param kinematics  at the start of the step
  /// @param loads       resized and overwritten
  void loads(const Kinematics& kinematics, const Eigen::MatrixXd& actuation, Loads& loads) const;

 private:
  std::vector<ActuatorSpecification> actuators_;
  std::vector<Signal> signals_;
};

}  // namespace copepod::coupler
