#include "analysis/swimmer_observer.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/as_in_paper.hpp"
#include "geometry/rotation.hpp"

namespace copepod::coupler {

SwimmerObserver::SwimmerObserver(const Swimmer& swimmer, int first_body)
    : swimmer_(swimmer),
      axis_(z_axis(swimmer.orientation_wxyz)),
      first_body_(first_body),
      start_step_((swimmer.three_beads->stroke.cycles - 1) * swimmer.three_beads->stroke.period_steps),
      stop_step_(swimmer.three_beads->stroke.cycles * swimmer.three_beads->stroke.period_steps) {}

void SwimmerObserver::observe(const StepRecord& record) {
  if (record.step >= start_step_ && record.step < stop_step_) sample(record);
  if (record.step == stop_step_) close_period(record);
}

void SwimmerObserver::finish(const StepRecord& last) {
  if (last.step == stop_step_) close_period(last);
}

void SwimmerObserver::close_period(const StepRecord& record) {
  if (sums_.samples != swimmer_.three_beads->stroke.period_steps) return;
  sums_.last_position_m = position_m(record, 1);
  sums_.complete = true;
}

double SwimmerObserver::position_m(const StepRecord& record, int bead) const {
  return record.kinematics.position_m.col(first_body_ + bead).dot(axis_);
}

void SwimmerObserver::sample(const StepRecord& record) {
  const Kinematics& state = record.kinematics;
  if (sums_.samples == 0) sums_.first_position_m = position_m(record, 1);
  // Whole periods lie before the window, so the phase counted from its start is the phase of t itself.
  const double phase = 2.0 * std::numbers::pi * static_cast<double>(record.step - start_step_) /
                       static_cast<double>(swimmer_.three_beads->stroke.period_steps);
  for (std::size_t arm = 0; arm < 2; ++arm) {
    const int near = first_body_ + static_cast<int>(arm);
    const double length = (state.position_m.col(near + 1) - state.position_m.col(near)).norm();
    if (sums_.samples == 0) sums_.first_arm_m[arm] = length;
    const double change = length - sums_.first_arm_m[arm];  // small numbers sum up with less rounding
    sums_.arm_m[arm] += change;
    sums_.arm_cosine_m[arm] += change * std::cos(phase);
    sums_.arm_sine_m[arm] += change * std::sin(phase);
  }
  for (int bead = 0; bead < 3; ++bead) {
    const auto velocity = state.velocity_m_per_s.col(first_body_ + bead);
    sums_.power_W += record.driving_N.col(first_body_ + bead).dot(velocity);
    double& fastest = sums_.max_speed_m_per_s[static_cast<std::size_t>(bead)];
    fastest = std::max(fastest, std::abs(velocity.dot(axis_)));
  }
  sums_.power_rounded_omega_W += power_with_rounded_omega_W(swimmer_, first_body_, record);
  ++sums_.samples;
}

/// Least squares on T equidistant samples of one whole period: 1, cos ωt and sin ωt are orthogonal there, so
///   l̄ = Σl/T,  A = 2 Σ l cos ωt / T,  B = 2 Σ l sin ωt / T,  d = √(A² + B²),  φ = atan2(−B, A)
std::optional<SwimmerMeasurement> SwimmerObserver::measurement() const {
  if (!sums_.complete) return {};
  const auto samples = static_cast<double>(sums_.samples);
  SwimmerMeasurement measured;
  measured.displacement_m = sums_.last_position_m - sums_.first_position_m;
  for (std::size_t arm = 0; arm < 2; ++arm) {
    const double a = 2.0 * sums_.arm_cosine_m[arm] / samples;
    const double b = 2.0 * sums_.arm_sine_m[arm] / samples;
    measured.arms[arm] = {sums_.first_arm_m[arm] + sums_.arm_m[arm] / samples, std::hypot(a, b), std::atan2(-b, a)};
  }
  measured.mean_power_W = sums_.power_W / samples;
  measured.mean_power_rounded_omega_W = sums_.power_rounded_omega_W / samples;
  measured.max_speed_m_per_s = sums_.max_speed_m_per_s;
  return measured;
}

}  // namespace copepod::coupler
