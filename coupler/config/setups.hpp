#pragma once

#include <set>
#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"
#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod::coupler {

// What the components receive of a case, and what it needs of them.

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
