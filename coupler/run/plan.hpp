#pragma once

#include <nlohmann/json_fwd.hpp>

#include "config/campaign.hpp"
#include "config/load_case.hpp"

namespace copepod::coupler {

/// Everything that the deploy command needs to know about a case: how to start it, what it needs, what it
/// will cost.
nlohmann::ordered_json make_plan(const LoadedCase& loaded);

/// The same for a campaign: its name, how many cases at once (null: unsaid), and of each case name, file and
/// settings.
nlohmann::ordered_json make_campaign_plan(const Campaign& campaign);

}  // namespace copepod::coupler
