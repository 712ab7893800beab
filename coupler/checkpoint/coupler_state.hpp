#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "analysis/swimmer_observer.hpp"
#include "contract/exchange.hpp"

namespace copepod::coupler {

/// What the coupler itself must remember to continue a run bit for bit; the solvers remember the rest.
struct CouplerState {
  std::int64_t step = 0;             ///< that comes next
  Loads previous_loads;              ///< of the load averaging; no bodies: none yet
  std::vector<PeriodSums> swimmers;  ///< of the analysis, in the order of the case
};

nlohmann::ordered_json to_json(const CouplerState& state);

/// @throws StorageError if something is missing or of the wrong kind
CouplerState coupler_state_from_json(const nlohmann::ordered_json& json);

}  // namespace copepod::coupler
