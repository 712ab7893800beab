#pragma once

#include "config/sections/case.hpp"
#include "config/yaml/value.hpp"

namespace copepod::coupler {

/// The case with every default spelled out; reading it again gives the same case, bit for bit.
/// A parameter set that was chosen stays as a label only: its values are written where they belong.
Value resolved(const Case& the_case);

/// What makes two runs the same physics: a digest of the resolved case without length of the run, output,
/// services and published figures.
std::string case_key(Case the_case);

}  // namespace copepod::coupler
