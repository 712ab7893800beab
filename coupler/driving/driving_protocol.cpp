#include "driving/driving_protocol.hpp"

#include <string>
#include <utility>

#include "contract/errors.hpp"
#include "driving/signal.hpp"

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

std::vector<DrivingTerm> stroke_terms(const Eigen::Vector3d& amplitude_N, std::int64_t period_steps,
                                      std::int64_t phase_lag_steps, std::int64_t cycles, int first_body) {
  const int trailing = first_body;
  const int middle = first_body + 1;
  const int leading = first_body + 2;
  const DrivingTerm pull{trailing, -amplitude_N, period_steps, 0, 0, cycles * period_steps};
  const DrivingTerm push{leading,         amplitude_N,     period_steps,
                         phase_lag_steps, phase_lag_steps, cycles * period_steps + phase_lag_steps};
  DrivingTerm against_pull = pull;
  against_pull.body = middle;
  against_pull.amplitude_N = -pull.amplitude_N;
  DrivingTerm against_push = push;
  against_push.body = middle;
  against_push.amplitude_N = -push.amplitude_N;
  return {pull, against_pull, against_push, push};
}

DrivingProtocol::DrivingProtocol(std::vector<DrivingTerm> terms, Eigen::Index bodies)
    : terms_(std::move(terms)), bodies_(bodies) {
  for (const DrivingTerm& term : terms_) {
    if (term.body < 0 || term.body >= bodies_) {
      throw CaseError("a driving force acts on body " + std::to_string(term.body) + " of " + std::to_string(bodies_) +
                      " (there is no such body). Name an existing body.");
    }
    if (term.period_steps < 0 || term.start_step < 0 || term.stop_step < term.start_step) {
      throw CaseError("a driving force has a negative period or duration (time runs forwards). Check its steps.");
    }
  }
}

void DrivingProtocol::sample(std::int64_t step, std::span<const double> nodes, Eigen::Matrix3Xd& force_N) const {
  force_N.setZero(3, static_cast<Eigen::Index>(nodes.size()) * bodies_);
  for (const DrivingTerm& term : terms_) {
    if (step < term.start_step || step >= term.stop_step) continue;
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      const double wave = term.period_steps == 0 ? 1.0 : sine_of_turns(turns(term, step, nodes[node]));
      force_N.col(static_cast<Eigen::Index>(node) * bodies_ + term.body) += wave * term.amplitude_N;
    }
  }
}

}  // namespace copepod::coupler
