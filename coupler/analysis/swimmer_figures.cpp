#include "analysis/swimmer_figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "contract/words.hpp"
#include "geometry/neighbour_grid.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;
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
  for (int bead = 0; bead < 3; ++bead)
    power_W += force_N[bead] * record.kinematics.velocity_m_per_s.col(first_body + bead).dot(axis);
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

namespace {

/// JSON has no infinities: what cannot be divided is null.
ordered_json number(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json number(const std::optional<double>& value) { return value ? number(*value) : ordered_json(nullptr); }

ordered_json by_bead(const std::array<std::optional<double>, 3>& values) {
  return {{"B2", number(values[0])}, {"B1", number(values[1])}, {"B3", number(values[2])}};
}

/// Converts to lattice units; NaN, hence null, without a lattice.
struct Lattice {
  explicit Lattice(const Case& the_case)
      : cell_size_m(the_case.fluid.cell_size_m > 0.0 ? the_case.fluid.cell_size_m : std::nan("")),
        step_s(the_case.step_s) {}
  double cell_size_m;
  double step_s;
  [[nodiscard]] double velocity(double velocity_m_per_s) const { return velocity_m_per_s * step_s / cell_size_m; }
  [[nodiscard]] double length(double length_m) const { return length_m / cell_size_m; }
  [[nodiscard]] double inverse_length(double per_m) const { return per_m * cell_size_m; }
};

/// Published figures at the places where the report has its own.
ordered_json published(const PublishedFigures& figures) {
  ordered_json report = ordered_json::object();
  for (const auto& [key, value] : figures) {
    const std::size_t dot = key.find('.');
    (dot == std::string::npos ? report[key] : report[key.substr(0, dot)][key.substr(dot + 1)]) = value;
  }
  return report;
}

ordered_json omega_figures(const OmegaFigures& figures, const Lattice& lattice) {
  return {{"omega_lattice", number(figures.omega_rad_per_s * lattice.step_s)},
          {"u_GA_lattice", number(lattice.velocity(figures.u_GA_m_per_s))},
          {"u_GA_m_per_s", number(figures.u_GA_m_per_s)},
          {"error_percent", number(figures.error_percent)},
          {"efficiency", number(figures.efficiency)}};
}

ordered_json numbers(const Eigen::VectorXd& values) {
  ordered_json list = ordered_json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

/// Key of a velocity in each of its units.
void add_speed(ordered_json& report, const std::string& key, double speed_m_per_s, const Group& group,
               const Lattice& lattice) {
  report[key + "_m_per_s"] = number(speed_m_per_s);
  report[key + "_um_per_s"] = number(1e6 * speed_m_per_s);
  report[key + "_cells_per_step"] = number(lattice.velocity(speed_m_per_s));
  const double period_s = static_cast<double>(group.period_steps) * lattice.step_s;
  report[key + "_lengths_per_cycle"] = number(speed_m_per_s * period_s / group.length_m);
}

/// The last full cycle of a swimmer of any shape.
ordered_json kinematics_report(const Group& group, const CycleSums& sums, const Case& the_case,
                               const Lattice& lattice) {
  const Cycle& cycle = sums.last;
  ordered_json report = {{"cycle", nullptr}};
  if (!group.note.empty()) report["note"] = group.note;
  if (cycle.number < 0) return report;
  const CycleFigures figures = evaluate(cycle, group, the_case.fluid, the_case.step_s);
  report["cycle"] = cycle.number;
  report["window_steps"] = {cycle.number * group.period_steps, (cycle.number + 1) * group.period_steps};
  report["period_steps"] = group.period_steps;
  add_speed(report, "u_along", figures.along_m_per_s, group, lattice);
  add_speed(report, "u_across", figures.across_m_per_s.norm(), group, lattice);
  if (const Eigen::Index cycles = sums.latest_along_m.size(); cycles >= 3) {
    const Eigen::ArrayXd along_m_per_s =
        sums.latest_along_m / (static_cast<double>(group.period_steps) * lattice.step_s);
    const double mean_m_per_s = along_m_per_s.mean();
    add_speed(report, "u_along_mean", mean_m_per_s, group, lattice);
    const double square = (along_m_per_s - mean_m_per_s).square().sum() / static_cast<double>(cycles - 1);
    add_speed(report, "u_along_spread", std::sqrt(square), group, lattice);
  }
  if (figures.u_GA_m_per_s) add_speed(report, "u_GA", *figures.u_GA_m_per_s, group, lattice);
  report["velocity_m_per_s"] = numbers(figures.velocity_m_per_s);
  report["velocity_across_m_per_s"] = numbers(figures.across_m_per_s);
  report["axis"] = numbers(figures.axis);
  report["tilt_rad"] = figures.tilt_rad;
  report["rotation_rad"] = numbers(figures.rotation_rad);
  report["arms"] = ordered_json::array();
  for (Eigen::Index arm = 0; arm < cycle.arms.cols(); ++arm) {
    const auto& ends = group.arms[arm];
    const auto name = [&](int body) {
      return group.body_names[std::ranges::find(group.bodies, body) - group.bodies.begin()];
    };
    report["arms"].push_back({{"bodies", {name(ends[0]), name(ends[1])}},
                              {"mean_m", number(cycle.arms(0, arm))},
                              {"amplitude_m", number(cycle.arms(1, arm))},
                              {"phase_rad", number(cycle.arms(2, arm))}});
  }
  report["power_W"] = number(cycle.power_W);
  report["dissipation_W"] = number(cycle.dissipation_W);
  report["efficiency"] = number(figures.efficiency);
  report["length_m"] = group.length_m;
  report["Re"] = number(figures.Re);
  report["max_speed_m_per_s"] = ordered_json::object();
  for (std::size_t i = 0; i < group.body_names.size(); ++i)
    report["max_speed_m_per_s"][group.body_names[i]] = number(cycle.max_speed_m_per_s[i]);
  report["at_rest"] =
      cycle.translation_m.norm() <= rest_in_a_cycle * group.length_m && figures.rotation_rad.norm() <= rest_in_a_cycle;
  const bool has_two = sums.before_last.number >= 0;
  const CycleChange from_last = has_two ? change(sums.before_last, cycle, group.length_m) : CycleChange{};
  report["change_from_last_cycle"] = {{"velocity", number(from_last.velocity)},
                                      {"rotation", number(from_last.rotation)}};
  return report;
}

/// The figures of the paper's tables, of the last driven cycle.
void add_figures_of_paper(ordered_json& report, const Swimmer& swimmer, const Group& group, const Cycle& cycle,
                          const Case& the_case, const Lattice& lattice) {
  const bool analysed = cycle.number >= 0 && cycle.number == group.stop_cycle - 1;
  report["analysed"] = analysed;
  report["window_steps"] = {(group.stop_cycle - 1) * group.period_steps, group.stop_cycle * group.period_steps};
  if (!swimmer.published.empty()) report["published"] = published(swimmer.published);
  if (!analysed) {
    for (const char* key : {"u_swim_lattice", "u_swim_m_per_s", "d1_cells", "d2_cells", "sin_dphi", "mean_arm_cells",
                            "K", "u_GA_lattice", "error_percent", "efficiency", "Re_swim", "Re_bodies"}) {
      report[key] = nullptr;
    }
    return;
  }
  const SwimmerFigures figures = evaluate(cycle, cycle.turned * group.axis, swimmer, the_case);
  report["u_swim_lattice"] = number(lattice.velocity(figures.u_swim_m_per_s));
  report["u_swim_m_per_s"] = number(figures.u_swim_m_per_s);
  report["d1_cells"] = number(lattice.length(cycle.arms(1, 0)));
  report["d2_cells"] = number(lattice.length(cycle.arms(1, 1)));
  report["sin_dphi"] = number(figures.sin_dphi);
  report["mean_arm_cells"] = {number(lattice.length(cycle.arms(0, 0))), number(lattice.length(cycle.arms(0, 1)))};
  report["K"] = number(lattice.inverse_length(figures.K_per_m));
  report.update(omega_figures(figures.at_omega, lattice));
  report["Re_swim"] = number(figures.Re_swim);
  report["Re_bodies"] = by_bead(figures.Re_bodies);
  report["mean_power_W"] = number(cycle.power_W);
  const Eigen::Vector3d speed_m_per_s = cycle.max_speed_along_m_per_s;
  report["max_speed_m_per_s"] = by_bead({speed_m_per_s[0], speed_m_per_s[1], speed_m_per_s[2]});
  if (!cycle.power_as_in_paper_W) return;
  const FiguresAsInPaper as_in_paper = evaluate_as_in_paper(figures, cycle, swimmer, the_case);
  ordered_json paper = omega_figures(as_in_paper.at_rounded_omega, lattice);
  paper["Re_bodies"] = by_bead(as_in_paper.Re_bodies);
  paper["mean_power_W"] = number(*cycle.power_as_in_paper_W);
  report["as_in_paper"] = paper;
}

/// All swimmers together: mean and standard deviation of the speed along their own axes and polar order |Σ e|/N, of the
/// last full cycle of each, and the distance from each centroid to the nearest other one at the end of the run.
ordered_json swarm_report(const Case& the_case, const CycleObserver& observer) {
  if (observer.end_position_m().cols() == 0) return nullptr;  // the run has not ended
  Eigen::Matrix3Xd centroids_m(3, the_case.swimmers.size());
  Eigen::VectorXd speeds_m_per_s(centroids_m.cols());
  Eigen::Vector3d order = Eigen::Vector3d::Zero();
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Group& group = observer.groups()[i];
    const CycleSums& sums = observer.sums()[i];
    if (sums.last.number < 0) continue;
    centroids_m.col(count) = observer.end_position_m()(Eigen::all, group.bodies).rowwise().mean();
    speeds_m_per_s[count++] = evaluate(sums.last, group, the_case.fluid, the_case.step_s).along_m_per_s;
    order += sums.turned * group.axis;
  }
  if (count < 2) return nullptr;
  const Eigen::VectorXd nearest_m =
      nearest_distances_m(centroids_m.leftCols(count), the_case.fluid.periodic_length_m());
  const auto speeds = speeds_m_per_s.head(count).array();
  return {{"swimmers", count},
          {"u_along_mean_m_per_s", number(speeds.mean())},
          {"u_along_spread_m_per_s", number(std::sqrt((speeds - speeds.mean()).square().mean()))},
          {"polar_order", number(order.norm() / static_cast<double>(count))},
          {"nearest_distance_mean_m", number(nearest_m.mean())},
          {"nearest_distance_least_m", number(nearest_m.minCoeff())}};
}

}  // namespace

Eigen::VectorXd nearest_distances_m(const Eigen::Matrix3Xd& points_m, const std::array<double, 3>& periodic_length_m) {
  const Eigen::Index points = points_m.cols();
  const double extent_m = (points_m.rowwise().maxCoeff() - points_m.rowwise().minCoeff()).norm();
  constexpr double least_m = 1e-100;  // where all points coincide
  const double first_m = std::max(extent_m / static_cast<double>(points), least_m);
  std::vector<double> radius_m(points, first_m);
  Eigen::VectorXd nearest_m = Eigen::VectorXd::Constant(points, std::numeric_limits<double>::infinity());
  std::vector<BodyPair> pairs;
  for (double largest_m = first_m;; largest_m *= 2.0) {
    NeighbourGrid grid(radius_m, periodic_length_m);
    grid.find_pairs(points_m, pairs);
    for (const auto& [a, b] : pairs) {
      const double distance_m = grid.images().nearest_m(points_m.col(b) - points_m.col(a)).norm();
      nearest_m[a] = std::min(nearest_m[a], distance_m);
      nearest_m[b] = std::min(nearest_m[b], distance_m);
    }
    if (largest_m > extent_m) return nearest_m;  // no point is further away
    bool grows = false;
    for (Eigen::Index i = 0; i < points; ++i) {
      double& radius = radius_m[i];
      if (nearest_m[i] <= radius) continue;  // all points in its ball are known
      radius *= 2.0;
      grows = true;
    }
    if (!grows) return nearest_m;
  }
}

ordered_json swimmer_reports(const Case& the_case, const CycleObserver& observer) {
  const Lattice lattice(the_case);
  ordered_json reports = {{"swimmers", ordered_json::array()}};
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    const Group& group = observer.groups()[i];
    const CycleSums& sums = observer.sums()[i];
    ordered_json report = {{"name", swimmer.name}};
    if (swimmer.three_beads) add_figures_of_paper(report, swimmer, group, sums.last, the_case, lattice);
    report["kinematics"] = kinematics_report(group, sums, the_case, lattice);
    reports["swimmers"].push_back(report);
  }
  for (std::size_t i = the_case.swimmers.size(); i < observer.groups().size(); ++i) {
    const Group& group = observer.groups()[i];
    reports["groups"].push_back(
        {{"name", group.name}, {"kinematics", kinematics_report(group, observer.sums()[i], the_case, lattice)}});
  }
  if (ordered_json swarm = swarm_report(the_case, observer); !swarm.is_null()) reports["swarm"] = swarm;
  return reports;
}

}  // namespace copepod::coupler
