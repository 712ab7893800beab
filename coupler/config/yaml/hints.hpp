#pragma once

#include <functional>
#include <string>
#include <vector>

namespace copepod::coupler {

/// "a, b, c"
std::string listed(const std::vector<std::string>& words);

/// What a user may have meant by a key that a section does not have: the same quantity in another unit or spelling, or
/// by another of its names; or a key of another section.
/// @param known      keys of the section
/// @param elsewhere  gives the paths of all keys, as in docs/case_keys.md; asked only where it is needed
/// @return "Did you mean …?", "It is a key of …." or "Known here: …."
std::string hint_for(const std::string& key, const std::vector<std::string>& known,
                     const std::function<std::vector<std::string>()>& elsewhere);

}  // namespace copepod::coupler
