#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "analysis/cycle_observer.hpp"
#include "config/sections/case.hpp"

namespace copepod::coupler {

/// The swimmers' part of summary.json: `swimmers`, an entry for each, `groups` where the case has them,
/// and for several swimmers `swarm`. Lattice figures
/// are in cells and steps (null without a cell size); what the run did not reach or the fluid has not got is null.
nlohmann::ordered_json swimmer_reports(const Case& the_case, const CycleObserver& observer);

}  // namespace copepod::coupler
