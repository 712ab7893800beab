#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/load_case.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

// Drag and lift coefficients of bodies and obstacles [docs/conventions.md], from the loads in the trajectory:
//   C = 2 F/(ρ U² A),   St = f L/U

/// Drag and lift of each in the case, in this order.
std::vector<std::string> coefficient_columns(const Case& the_case);
/// None between the samples of the trajectory.
Eigen::VectorXd coefficients_in(const StepRecord& record, const LoadedCase& loaded);
/// What coefficients.csv amounts to, for summary.json. Where the lift oscillates, the figures are of its whole periods,
/// at least two, from its first rise through its mean to the last one; otherwise of all samples from `from_step` on.
nlohmann::ordered_json coefficient_report(const std::filesystem::path& table, const Case& the_case);
/// What flow.csv amounts to, for summary.json: mean, deviation from it, least and most of each column from a step on.
nlohmann::ordered_json flow_report(const std::filesystem::path& table, const std::vector<std::string>& names,
                                   std::int64_t from_step);

}  // namespace copepod::coupler
