#pragma once

#include <array>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "analysis/cycle_observer.hpp"
#include "config/sections/case.hpp"

namespace copepod::coupler {

/// Distance from each of several points to the nearest other one [m], in time linear in their number where they are
/// spread evenly: balls about the points grow until they meet another.
/// @param points_m           finite, shape (3, points ≥ 2)
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
Eigen::VectorXd nearest_distances_m(const Eigen::Matrix3Xd& points_m, const std::array<double, 3>& periodic_length_m);

/// The swimmers' part of summary.json: `swimmers`, an entry for each, `groups` where the case has them,
/// and for several swimmers `swarm`. Lattice figures
/// are in cells and steps (null without a cell size); what the run did not reach or the fluid has not got is null.
nlohmann::ordered_json swimmer_reports(const Case& the_case, const CycleObserver& observer);

}  // namespace copepod::coupler
