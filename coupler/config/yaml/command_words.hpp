#pragma once

#include <string>
#include <vector>

namespace copepod::coupler {

/// Splits a command like a shell would: spaces separate, quotes and backslashes keep together.
/// @throws CaseError if a quote is not closed
std::vector<std::string> split_command(const std::string& command);

}  // namespace copepod::coupler
