#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace copepod::coupler {

/// Writes `folder`/manifest.json: case, step, and size and checksum of every other file below `folder`.
/// @throws StorageError
void write_manifest(const std::filesystem::path& folder, const std::string& case_key, std::int64_t step);

/// Compares a folder with its manifest.
/// @return what is wrong with it, empty if nothing is
std::string find_damage(const std::filesystem::path& folder, const std::string& case_key);

}  // namespace copepod::coupler
