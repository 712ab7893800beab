#pragma once

#include <string>

namespace copepod::fluid {

/// Makes a finished file known under its name for good: its contents and its folder are on the disk on
/// return.
/// @throws StorageError; the file then keeps its unfinished name
void publish(const std::string& unfinished, const std::string& path);

}  // namespace copepod::fluid
