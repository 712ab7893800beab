#pragma once

#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"
#include "config/yaml/reader.hpp"

namespace copepod::coupler {

/// A case that passed every check, ready to run.
struct LoadedCase {
  Case content;
  Assembly assembly;
  std::vector<std::string> warnings;  ///< "file:line: warning: …"
};

/// Reads and checks a case file.
/// @param overrides  "key.path=value", as after --set; later ones win
/// @throws CaseInvalid with every error found
LoadedCase load_case(const std::string& file, const std::vector<std::string>& overrides);

/// The same from text; `source` names it in messages. `asked`, if given, receives every key
/// that the reading asks for.
LoadedCase load_case_text(const std::string& text, const std::string& source,
                          const std::vector<std::string>& overrides, AskedKeys* asked = nullptr);

}  // namespace copepod::coupler
