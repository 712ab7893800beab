#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace copepod::coupler {

/// One driving force: constant, or sinusoidal, on one body during steps [start, stop).
///   F(t) = A                        for period 0
///   F(t) = A sin(2π (t − φ)/T)      otherwise, t, φ, T in steps
struct DrivingTerm {
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

  int body = 0;
  Eigen::Vector3d amplitude_N = Eigen::Vector3d::Zero();
  std::int64_t period_steps = 0;
  std::int64_t phase_lag_steps = 0;
  std::int64_t start_step = 0;
  std::int64_t stop_step = never;
};

/// The stroke of a three-bead swimmer whose bodies are trailing B2 = first_body, middle B1, leading B3:
///   F_B2 = −a sin(2π t/T)          for 0 ≤ t < cycles·T       [paper, eq. (19)]
///   F_B3 =  a sin(2π (t − φ)/T)    for φ ≤ t < cycles·T + φ   [paper, eq. (20), with the delay its text
///   describes] F_B1 = −(F_B2 + F_B3)                                     [paper, eq. (21)]
/// @param amplitude_N  a times the unit vector from trailing to leading [N]
std::vector<DrivingTerm> stroke_terms(const Eigen::Vector3d& amplitude_N, std::int64_t period_steps,
                                      std::int64_t phase_lag_steps, std::int64_t cycles, int first_body);

/// All driving forces of a case, sampled at any place inside a step.
class DrivingProtocol {
 public:
  /// @throws CaseError if a term is on a body that does not exist, or its period or window is negative
  DrivingProtocol(std::vector<DrivingTerm> terms, Eigen::Index bodies);

  /// Forces at times (step + node) of one step.
  /// A term acts in a whole step or not at all: which one is decided by the step, not by the node, so a force
  /// that is switched at the end of a step does not leak into its last node.
  /// @param nodes    fractions of the step
  /// @param force_N  resized to (3, nodes × bodies) and overwritten: node 0 of all bodies, then node 1, …
  void sample(std::int64_t step, std::span<const double> nodes, Eigen::Matrix3Xd& force_N) const;

 private:
  std::vector<DrivingTerm> terms_;
  Eigen::Index bodies_;
};

}  // namespace copepod::coupler
