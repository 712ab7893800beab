#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/sections/case.hpp"
#include "config/sections/sections.hpp"

namespace copepod::coupler {

/// A case that passed every check, ready to run; of a sweep the first member, once all have passed.
struct LoadedCase {
  Case content;
  Assembly assembly;
  std::optional<Sweep> sweep;
  std::vector<std::string> warnings;  ///< "file:line: warning: …"
};

/// Reads and checks a case file.
/// @param overrides  "key.path=value", as after --set; later ones win
/// @throws CaseInvalid with every error found
LoadedCase load_case(const std::string& file, const std::vector<std::string>& overrides);

/// The same from text; `source` names it in messages.
LoadedCase load_case_text(const std::string& text, const std::string& source,
                          const std::vector<std::string>& overrides);

/// One case of a campaign.
struct CampaignEntry {
  std::string name;                   ///< of its run directory
  std::string case_file;              ///< path, a relative one seen from the campaign file already resolved
  std::vector<std::string> settings;  ///< "key.path=value", as after --set
};

/// A list of cases that are run as one.
struct Campaign {
  std::string name;
  std::int64_t jobs = 0;  ///< cases at once; 0: as many as there are cores
  std::vector<CampaignEntry> cases;
};

/// Whether a file lists cases, rather than being one; a pipe holds a case.
/// @throws CaseInvalid if it is not a YAML mapping
bool names_campaign(const std::string& file);

/// Reads a campaign file; the cases themselves are not looked into.
/// @param overrides  "key.path=value" for every case, after its own settings
/// @throws CaseInvalid with every error found
Campaign load_campaign(const std::string& file, const std::vector<std::string>& overrides = {});

/// JSON schema of a campaign file.
nlohmann::ordered_json campaign_schema();

}  // namespace copepod::coupler
