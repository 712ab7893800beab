#pragma once

#include <vector>

#include "analysis/cycle.hpp"
#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"

namespace copepod::coupler {

/// The swimmers of a case, then its groups, as the analysis sees them. Arms are the springs between their bodies.
///
/// The period is that of all periodic signals on a swimmer's bodies. If they differ, it is, with a note, their least
/// common multiple, or the longest of them where that is more than ten times as long. Cycles count that lie between the
/// first start of these signals and the first stop.
std::vector<Group> groups_of(const Case& the_case, const Assembly& assembly);

/// Whether any has a period.
bool have_cycles(const std::vector<Group>& groups);

}  // namespace copepod::coupler
