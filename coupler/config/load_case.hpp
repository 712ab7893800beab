#pragma once

#include <optional>
#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"
#include "config/sections/sweep.hpp"

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

}  // namespace copepod::coupler
