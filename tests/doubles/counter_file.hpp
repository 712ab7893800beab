#pragma once

#include <array>
#include <cstdint>
#include <fstream>
#include <string>

#include "contract/errors.hpp"

namespace copepod::doubles {

/// Checkpoint of the fluid double: two numbers in a text file.
inline void write_counters(const std::string& path, const std::array<std::uint64_t, 2>& counters) {
  std::ofstream file(path);
  file << counters[0] << ' ' << counters[1] << '\n';
  file.flush();
  if (!file) throw StorageError("The file " + path + " cannot be written (no such folder?). Choose another path.");
}

inline std::array<std::uint64_t, 2> read_counters(const std::string& path) {
  std::ifstream file(path);
  std::array<std::uint64_t, 2> counters{};
  if (!(file >> counters[0] >> counters[1])) {
    throw StorageError("The file " + path + " cannot be read (missing or damaged). Choose another checkpoint.");
  }
  return counters;
}

}  // namespace copepod::doubles
