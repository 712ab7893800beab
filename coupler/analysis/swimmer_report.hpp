#pragma once

#include <nlohmann/json_fwd.hpp>

#include "analysis/swimmer_observer.hpp"
#include "config/sections/case.hpp"

namespace copepod::coupler {

/// A swimmer's entry in summary.json: lattice figures in cells and steps (null without a cell size),
/// everything that the run did not reach or the fluid has not got as null.
nlohmann::ordered_json swimmer_report(const Swimmer& swimmer, const SwimmerObserver& observer, const Case& the_case);

}  // namespace copepod::coupler
