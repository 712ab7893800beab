#include "analysis/swimmer_report.hpp"

#include <cmath>

#include <nlohmann/json.hpp>

#include "analysis/as_in_paper.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// JSON has no infinities: what cannot be divided is null.
ordered_json number(double value) { return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr); }

ordered_json number(const std::optional<double>& value) { return value ? number(*value) : ordered_json(nullptr); }

ordered_json by_bead(const std::array<std::optional<double>, 3>& values) {
  return {{"B2", number(values[0])}, {"B1", number(values[1])}, {"B3", number(values[2])}};
}

/// Converts to lattice units; NaN, hence null, without a lattice.
struct Lattice {
  double cell_size_m;
  double step_s;
  [[nodiscard]] double velocity(double velocity_m_per_s) const {
    return cell_size_m > 0.0 ? velocity_m_per_s * step_s / cell_size_m : std::nan("");
  }
  [[nodiscard]] double length(double length_m) const {
    return cell_size_m > 0.0 ? length_m / cell_size_m : std::nan("");
  }
  [[nodiscard]] double inverse_length(double per_m) const {
    return cell_size_m > 0.0 ? per_m * cell_size_m : std::nan("");
  }
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

}  // namespace

ordered_json swimmer_report(const Swimmer& swimmer, const SwimmerObserver& observer, const Case& the_case) {
  const Lattice lattice{the_case.fluid.cell_size_m, the_case.step_s};
  const auto measured = observer.measurement();
  ordered_json report = {{"name", swimmer.name},
                         {"analysed", measured.has_value()},
                         {"window_steps", {observer.start_step(), observer.stop_step()}}};
  if (!swimmer.published.empty()) report["published"] = published(swimmer.published);
  if (!measured) {
    for (const char* key : {"u_swim_lattice", "u_swim_m_per_s", "d1_cells", "d2_cells", "sin_dphi", "mean_arm_cells",
                            "K", "u_GA_lattice", "error_percent", "efficiency", "Re_swim", "Re_bodies"}) {
      report[key] = nullptr;
    }
    return report;
  }
  const SwimmerFigures figures = evaluate(*measured, swimmer, the_case);
  report["u_swim_lattice"] = number(lattice.velocity(figures.u_swim_m_per_s));
  report["u_swim_m_per_s"] = number(figures.u_swim_m_per_s);
  report["d1_cells"] = number(lattice.length(measured->arms[0].amplitude_m));
  report["d2_cells"] = number(lattice.length(measured->arms[1].amplitude_m));
  report["sin_dphi"] = number(figures.sin_dphi);
  report["mean_arm_cells"] = {number(lattice.length(measured->arms[0].mean_m)),
                              number(lattice.length(measured->arms[1].mean_m))};
  report["K"] = number(lattice.inverse_length(figures.K_per_m));
  report.update(omega_figures(figures.at_omega, lattice));
  report["Re_swim"] = number(figures.Re_swim);
  report["Re_bodies"] = by_bead(figures.Re_bodies);
  report["mean_power_W"] = number(measured->mean_power_W);
  report["max_speed_m_per_s"] = {{"B2", number(measured->max_speed_m_per_s[0])},
                                 {"B1", number(measured->max_speed_m_per_s[1])},
                                 {"B3", number(measured->max_speed_m_per_s[2])}};
  const FiguresAsInPaper as_in_paper = evaluate_as_in_paper(figures, *measured, swimmer, the_case);
  ordered_json paper = omega_figures(as_in_paper.at_rounded_omega, lattice);
  paper["Re_bodies"] = by_bead(as_in_paper.Re_bodies);
  paper["mean_power_W"] = number(measured->mean_power_rounded_omega_W);
  report["as_in_paper"] = paper;
  return report;
}

}  // namespace copepod::coupler
