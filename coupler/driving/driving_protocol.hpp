#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"

namespace copepod::coupler {

/// How the value of an actuator varies in time: constant or sinusoidal during steps [start, stop), else 0.
///   s(t) = A                        for period 0
///   s(t) = A sin(2π (t − φ)/T)      otherwise, t, φ, T in steps
struct DrivingTerm {
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

  double amplitude = 0.0;  ///< [N], of a torque [N m]
  std::int64_t period_steps = 0;
  std::int64_t phase_lag_steps = 0;
  std::int64_t start_step = 0;
  std::int64_t stop_step = never;
};

/// An actuator and how its value varies.
struct DrivenActuator {
  ActuatorSpecification actuator;
  DrivingTerm term;
};

/// The stroke of a three-bead swimmer whose bodies are trailing B2 = first_body, middle B1, leading B3: a pair force
/// on each arm,
///   s₁ = a sin(2π t/T)          for 0 ≤ t < cycles·T,      −s₁ on B2 and s₁ on B1     [paper, eqs. (19), (21)]
///   s₂ = a sin(2π (t − φ)/T)    for φ ≤ t < cycles·T + φ,  −s₂ on B1 and s₂ on B3     [paper, eqs. (20), (21), with
///                                                                                   the delay that its text describes]
std::vector<DrivenActuator> stroke_terms(double amplitude_N, std::int64_t period_steps, std::int64_t phase_lag_steps,
                                         std::int64_t cycles, int first_body);

/// The drive of a case: all actuators, sampled at any place inside a step.
class DrivingProtocol {
 public:
  /// @throws CaseError if a period or window is negative
  explicit DrivingProtocol(const std::vector<DrivenActuator>& drive);

  /// Values at times (step + node) of one step.
  /// A term acts in a whole step or not at all: which one is decided by the step, not by the node, so a force
  /// that is switched at the end of a step does not leak into its last node.
  /// @param nodes      fractions of the step
  /// @param actuation  resized to (actuators, nodes) and overwritten
  void sample(std::int64_t step, std::span<const double> nodes, Eigen::MatrixXd& actuation) const;

  /// What the values at the start of a step exert on the bodies.
  /// @param kinematics  at the start of the step
  /// @param loads       resized and overwritten
  void loads(const Kinematics& kinematics, const Eigen::MatrixXd& actuation, Loads& loads) const;

 private:
  std::vector<ActuatorSpecification> actuators_;
  std::vector<DrivingTerm> terms_;
};

}  // namespace copepod::coupler
