#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/load_case.hpp"

namespace copepod::coupler {

/// Everything that the deploy command needs to know about a case: how to start it, what it needs, what it
/// will cost.
nlohmann::ordered_json make_plan(const LoadedCase& loaded);

}  // namespace copepod::coupler
