#include "run/summary.hpp"

#include <array>
#include <cstdio>

#include <nlohmann/json.hpp>

#include "config/sections/case.hpp"
#include "contract/digest.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

template <typename Matrix>
void add_all(Digest& digest, const Matrix& matrix) {
  for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) digest.add(matrix(row, column));
  }
}

std::string hexadecimal(std::uint64_t value) {
  std::array<char, 17> text{};
  std::snprintf(text.data(), text.size(), "%016llx", static_cast<unsigned long long>(value));
  return text.data();
}

/// Time that a solver worked [s]: all its phases but those in which it waited. For a component that reports
/// none, the time that the coupler waited for it.
double busy_s(const SolverSummary& solver, double waited_s) {
  if (solver.seconds.empty()) return waited_s;
  double sum_s = 0.0;
  for (const auto& [phase, seconds] : solver.seconds) sum_s += solver.waiting_phases.contains(phase) ? 0.0 : seconds;
  return sum_s;
}

/// Part of the loop that a fluid without bodies and without partners would not have needed: messages, waiting
/// for them, and what the fluid does for its bodies. The wait of its ranks for each other's halos is its own.
/// @return null for a fluid that reports no phases
ordered_json coupling_overhead(const SolverSummary& fluid, double loop_s) {
  if (fluid.seconds.empty()) return nullptr;
  double alone_s = 0.0;
  for (const auto& [phase, seconds] : fluid.seconds) alone_s += fluid.body_phases.contains(phase) ? 0.0 : seconds;
  return loop_s > 0.0 ? 1.0 - alone_s / loop_s : 0.0;
}

}  // namespace

std::uint64_t run_digest(const SolverSummary& fluid, const SolverSummary& body, const Kinematics& kinematics) {
  Digest digest;
  digest.add(fluid.digest);
  digest.add(body.digest);
  digest.add(static_cast<std::uint64_t>(kinematics.step));
  add_all(digest, kinematics.position_m);
  add_all(digest, kinematics.orientation_wxyz);
  add_all(digest, kinematics.velocity_m_per_s);
  add_all(digest, kinematics.angular_velocity_rad_per_s);
  return digest.value();
}

ordered_json make_summary(const Case& the_case, std::int64_t steps_done, const SolverSummary& fluid,
                          const SolverSummary& body, const Kinematics& kinematics, const RunTiming& timing,
                          const ordered_json& swimmers) {
  const double own_s = timing.loop_s - timing.fluid_wait_s - timing.body_wait_s;
  ordered_json summary;
  summary["case"] = the_case.name;
  summary["parameter_set"] =
      the_case.parameter_set.empty() ? ordered_json(nullptr) : ordered_json(the_case.parameter_set);
  summary["status"] = "finished";
  summary["steps"] = steps_done;
  summary["resumed_from_step"] = timing.first_step > 0 ? ordered_json(timing.first_step) : ordered_json(nullptr);
  summary["step_s"] = the_case.step_s;
  summary["cell_size_m"] =
      the_case.fluid.cell_size_m > 0.0 ? ordered_json(the_case.fluid.cell_size_m) : ordered_json(nullptr);
  summary["wall_s"] = timing.loop_s;
  const std::int64_t computed = steps_done - timing.first_step;  // the solver counts from step 0
  const double share = steps_done > 0 ? static_cast<double>(computed) / static_cast<double>(steps_done) : 0.0;
  summary["mlups"] = timing.loop_s > 0.0 ? share * static_cast<double>(fluid.cell_updates) / timing.loop_s * 1e-6 : 0.0;
  summary["ranks"] = fluid.ranks;
  summary["precision"] = name_of(precision_names, the_case.fluid.precision);
  summary["digest"] = hexadecimal(run_digest(fluid, body, kinematics));
  summary["mass_drift"] = fluid.mass_drift ? ordered_json(*fluid.mass_drift) : ordered_json(nullptr);
  summary["momentum_drift"] = fluid.momentum_drift ? ordered_json(*fluid.momentum_drift) : ordered_json(nullptr);
  summary["timing"] = {{"fluid_s", busy_s(fluid, timing.fluid_wait_s)},
                       {"body_s", busy_s(body, timing.body_wait_s)},
                       {"coupler_s", own_s},
                       {"exchange_wait_s", timing.fluid_wait_s},
                       {"body_wait_s", timing.body_wait_s},
                       {"coupling_overhead", coupling_overhead(fluid, timing.loop_s)}};
  summary["phases_s"] = {{"fluid", fluid.seconds}, {"body", body.seconds}};
  summary.update(swimmers);
  return summary;
}

}  // namespace copepod::coupler
