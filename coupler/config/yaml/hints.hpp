#pragma once

#include <string>
#include <vector>

namespace copepod::coupler {

/// What a user may have meant by a key that a section does not have: the same quantity in another unit or spelling, or
/// by another of its names; or a key of another section.
/// @param known      keys of the section
/// @param elsewhere  paths of all keys, as in docs/case_keys.md
/// @return "Did you mean …?", "It is a key of …." or "Known here: …."
std::string hint_for(const std::string& key, const std::vector<std::string>& known,
                     const std::vector<std::string>& elsewhere);

}  // namespace copepod::coupler
