#pragma once

#include <string>

#include "contract/timeline.hpp"

namespace copepod::recording {

/// Phases of `timeline` go to a new file `folder`/`process`.rank`rank`.rec from now on, until it is closed. A
/// phase then costs some 100 ns.
/// @param process  "coupler", "fluid" or "body"
/// @throws StorageError
void open_timeline(Timeline& timeline, const std::string& folder, const std::string& process, int rank);

}  // namespace copepod::recording
