#pragma once

#include <string>
#include <vector>

namespace copepod::coupler {

/// The known word closest to `word`, for "Did you mean …?"; empty if none is close.
std::string nearest_word(const std::string& word, const std::vector<std::string>& known);

}  // namespace copepod::coupler
