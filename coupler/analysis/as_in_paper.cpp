#include "analysis/as_in_paper.hpp"

#include <charconv>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace copepod::coupler {

double rounded_omega_per_step(std::int64_t period_steps) {
  // Through decimal text, because the captions round decimal digits and 22 × 10⁻⁵ in binary is not quite
  // 0.00022.
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1e", 2.0 * std::numbers::pi / static_cast<double>(period_steps));
  double rounded = 0.0;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

double power_with_rounded_omega_W(const Stroke& stroke, int first_body, const Eigen::Vector3d& axis,
                                  const StepRecord& record) {
  const double omega = rounded_omega_per_step(stroke.period_steps);
  const auto t = static_cast<double>(record.step);
  const double on_trailing = -stroke.amplitude_N * std::sin(omega * t);
  const double on_leading = stroke.amplitude_N * std::sin(omega * (t - static_cast<double>(stroke.phase_lag_steps)));
  const std::array<double, 3> force_N{on_trailing, -(on_trailing + on_leading), on_leading};
  double power_W = 0.0;
  for (int bead = 0; bead < 3; ++bead) {
    const double speed = record.kinematics.velocity_m_per_s.col(first_body + bead).dot(axis);
    power_W += force_N[static_cast<std::size_t>(bead)] * speed;
  }
  return power_W;
}

FiguresAsInPaper evaluate_as_in_paper(const SwimmerFigures& figures, const SwimmerMeasurement& measured, double power_W,
                                      const Swimmer& swimmer, const Case& the_case) {
  FiguresAsInPaper result;
  const double omega_rad_per_s = rounded_omega_per_step(swimmer.three_beads->stroke.period_steps) / the_case.step_s;
  result.at_rounded_omega = figures_at(omega_rad_per_s, power_W, figures, measured, swimmer, the_case.fluid);
  const auto& [B2, B1, B3] = measured.max_speed_m_per_s;
  result.Re_bodies = reynolds_numbers({B1, B2, B3}, swimmer, the_case.fluid);
  return result;
}

}  // namespace copepod::coupler
