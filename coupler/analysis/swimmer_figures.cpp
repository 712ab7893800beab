#include "analysis/swimmer_figures.hpp"

#include <cmath>
#include <numbers>

#include <spdlog/fmt/fmt.h>

#include "contract/words.hpp"

namespace copepod::coupler {

namespace {

using std::numbers::pi;

std::array<double, 3> equivalent_radii_m(const Swimmer& swimmer) {
  return {equivalent_radius_m(swimmer.beads[0].shape), equivalent_radius_m(swimmer.beads[1].shape),
          equivalent_radius_m(swimmer.beads[2].shape)};
}

/// @param power_W  mean driving power
OmegaFigures figures_at(double omega_rad_per_s, double power_W, const SwimmerFigures& figures, const Cycle& cycle,
                        const Swimmer& swimmer, const FluidCase& fluid) {
  OmegaFigures at;
  at.omega_rad_per_s = omega_rad_per_s;
  // u_GA = K d₁ d₂ ω sin(φ₁ − φ₂)   [paper, eq. (28)]
  at.u_GA_m_per_s = figures.K_per_m * cycle.arms(1, 0) * cycle.arms(1, 1) * omega_rad_per_s * figures.sin_dphi;
  at.error_percent = 100.0 * std::abs((at.u_GA_m_per_s - figures.u_swim_m_per_s) / at.u_GA_m_per_s);
  const std::array<double, 3> radii_m = equivalent_radii_m(swimmer);
  at.efficiency = efficiency(radii_m[0] + radii_m[1] + radii_m[2], figures.u_swim_m_per_s, power_W, fluid);
  return at;
}

/// Reynolds numbers of B2, B1, B3 [paper, eq. (26)], absent in vacuum.
std::array<std::optional<double>, 3> reynolds_numbers(const Eigen::Vector3d& speed_m_per_s, const Swimmer& swimmer,
                                                      const FluidCase& fluid) {
  std::array<std::optional<double>, 3> numbers;
  const double viscosity = fluid.kinematic_viscosity_m2_per_s;
  for (int bead = 0; bead < 3 && viscosity > 0.0; ++bead)
    numbers[bead] = speed_m_per_s[bead] * extent_along_m(swimmer.beads[bead]) / viscosity;
  return numbers;
}

}  // namespace

std::optional<double> efficiency(double effective_radius_m, double speed_m_per_s, double power_W,
                                 const FluidSetup& fluid) {
  const double drag_kg_per_s = stokes_drag_kg_per_s(effective_radius_m, fluid);
  if (drag_kg_per_s == 0.0 || power_W == 0.0) return {};
  return drag_kg_per_s * speed_m_per_s * speed_m_per_s / power_W;
}

double geometrical_factor_per_m(const std::array<double, 3>& radii_m, const std::array<double, 2>& mean_arms_m) {
  const double sum = radii_m[0] + radii_m[1] + radii_m[2];
  const double both = mean_arms_m[0] + mean_arms_m[1];
  const double arms =
      1.0 / (mean_arms_m[0] * mean_arms_m[0]) + 1.0 / (mean_arms_m[1] * mean_arms_m[1]) - 1.0 / (both * both);
  return 3.0 * radii_m[0] * radii_m[1] * radii_m[2] / (2.0 * sum * sum) * arms;
}

double rest_length_m(const Swimmer& swimmer) {
  double length = swimmer.three_beads->rest_gap_m[0] + swimmer.three_beads->rest_gap_m[1];
  for (const Bead& bead : swimmer.beads) length += extent_along_m(bead);
  return length;
}

SwimmerFigures evaluate(const Cycle& cycle, const Eigen::Vector3d& axis, const Swimmer& swimmer, const Case& the_case) {
  const double period_s = static_cast<double>(swimmer.three_beads->stroke.period_steps) * the_case.step_s;
  SwimmerFigures figures;
  figures.u_swim_m_per_s = cycle.displacement_m.col(1).dot(axis) / period_s;
  figures.sin_dphi = std::sin(cycle.arms(2, 0) - cycle.arms(2, 1));
  figures.K_per_m = geometrical_factor_per_m(equivalent_radii_m(swimmer), {cycle.arms(0, 0), cycle.arms(0, 1)});
  figures.at_omega = figures_at(2.0 * pi / period_s, cycle.power_W, figures, cycle, swimmer, the_case.fluid);
  const double viscosity = the_case.fluid.kinematic_viscosity_m2_per_s;
  if (viscosity > 0.0) figures.Re_swim = std::abs(figures.u_swim_m_per_s) * rest_length_m(swimmer) / viscosity;
  figures.Re_bodies = reynolds_numbers(cycle.max_speed_along_m_per_s, swimmer, the_case.fluid);
  return figures;
}

double rounded_omega_per_step(std::int64_t period_steps) {
  // Through decimal text, because the captions round decimal digits and 22 × 10⁻⁵ in binary is not quite
  // 0.00022.
  return number_in<double>(fmt::format("{:.1e}", 2.0 * pi / static_cast<double>(period_steps))).value();
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
    power_W += force_N[bead] * speed;
  }
  return power_W;
}

FiguresAsInPaper evaluate_as_in_paper(const SwimmerFigures& figures, const Cycle& cycle, const Swimmer& swimmer,
                                      const Case& the_case) {
  FiguresAsInPaper result;
  const double omega_rad_per_s = rounded_omega_per_step(swimmer.three_beads->stroke.period_steps) / the_case.step_s;
  result.at_rounded_omega =
      figures_at(omega_rad_per_s, *cycle.power_as_in_paper_W, figures, cycle, swimmer, the_case.fluid);
  const Eigen::Vector3d speed_m_per_s = cycle.max_speed_along_m_per_s;
  result.Re_bodies = reynolds_numbers({speed_m_per_s[1], speed_m_per_s[0], speed_m_per_s[2]}, swimmer, the_case.fluid);
  return result;
}

}  // namespace copepod::coupler
