#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"
#include "config/sections/sweep.hpp"
#include "config/yaml/reader.hpp"
#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/fluid_setup.hpp"

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

/// The same from text; `source` names it in messages. `asked`, if given, receives every key
/// that the reading asks for.
LoadedCase load_case_text(const std::string& text, const std::string& source, const std::vector<std::string>& overrides,
                          AskedKeys* asked = nullptr);

/// @param field_directory  absolute path of the run directory
FluidSetup make_fluid_setup(const Case& the_case, const Assembly& assembly, const std::string& field_directory);
BodySetup make_body_setup(const Case& the_case, const Assembly& assembly);

/// Features that a case requires of its components: those of the setup (contract/features.hpp) and those of
/// the run.
std::set<std::string> required_of_fluid(const Case& the_case, const Assembly& assembly);
std::set<std::string> required_of_body(const Case& the_case, const BodySetup& setup);

/// What to report to the user about a component: required features that it neglects, and announced names that
/// are not features.
/// @throws Refused naming the features that the component lacks
std::vector<std::string> require_features(const Capabilities& capabilities, const std::set<std::string>& required);

}  // namespace copepod::coupler
