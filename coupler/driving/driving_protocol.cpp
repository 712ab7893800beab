#include "driving/driving_protocol.hpp"

#include "contract/errors.hpp"
#include "driving/signal.hpp"
#include "geometry/actuator_loads.hpp"

namespace copepod::coupler {
namespace {

/// Phase in turns. The whole periods are taken off in integers, so that the phase of the millionth step is as
/// exact as that of the first.
double turns(const DrivingTerm& term, std::int64_t step, double node) {
  std::int64_t within = (step - term.phase_lag_steps) % term.period_steps;
  if (within < 0) within += term.period_steps;
  return (static_cast<double>(within) + node) / static_cast<double>(term.period_steps);
}

}  // namespace

std::vector<DrivenActuator> stroke_terms(double amplitude_N, std::int64_t period_steps, std::int64_t phase_lag_steps,
                                         std::int64_t cycles, int first_body) {
  const auto arm = [&](int number, std::int64_t lag_steps) {
    DrivenActuator driven{{}, {amplitude_N, period_steps, lag_steps, lag_steps, cycles * period_steps + lag_steps}};
    driven.actuator.body_A = first_body + number;
    driven.actuator.body_B = first_body + number + 1;
    return driven;
  };
  return {arm(0, 0), arm(1, phase_lag_steps)};
}

DrivingProtocol::DrivingProtocol(const std::vector<DrivenActuator>& drive) {
  for (const auto& [actuator, term] : drive) {
    if (term.period_steps < 0 || term.start_step < 0 || term.stop_step < term.start_step) {
      throw CaseError("a driving force has a negative period or duration (time runs forwards). Check its steps.");
    }
    actuators_.push_back(actuator);
    terms_.push_back(term);
  }
}

void DrivingProtocol::sample(std::int64_t step, std::span<const double> nodes, Eigen::MatrixXd& actuation) const {
  actuation.setZero(static_cast<Eigen::Index>(terms_.size()), static_cast<Eigen::Index>(nodes.size()));
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    const DrivingTerm& term = terms_[i];
    if (step < term.start_step || step >= term.stop_step) continue;
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const double wave = term.period_steps == 0 ? 1.0 : sine_of_turns(turns(term, step, nodes[node]));
      actuation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(node)) = wave * term.amplitude;
    }
  }
}

void DrivingProtocol::loads(const Kinematics& kinematics, const Eigen::MatrixXd& actuation, Loads& loads) const {
  drive_loads(actuators_, actuation.col(0), kinematics, loads);
}

}  // namespace copepod::coupler
