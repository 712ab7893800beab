#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/campaign.hpp"
#include "config/load_case.hpp"

namespace copepod::coupler {

/// The description of a case for the deploy command: how to start it, what it requires, what it will cost.
nlohmann::ordered_json make_plan(const LoadedCase& loaded);

/// The same for a campaign: its name, how many cases at once (null: not given), and name, file and settings
/// of each case.
nlohmann::ordered_json make_campaign_plan(const Campaign& campaign);

}  // namespace copepod::coupler
