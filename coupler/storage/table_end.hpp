#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace copepod::coupler {

/// Where a table of a run directory ended at some time, and the checksum of what it held until there: of a CSV file all
/// bytes, of an HDF5 file the samples.
struct TableEnd {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;

  bool operator==(const TableEnd&) const = default;
};

using TableEnds = std::map<std::string, TableEnd>;  ///< by name of the file

/// What is wrong with a table that is to be continued from `end`; empty if nothing is.
std::string find_damage(const std::string& path, const TableEnd& end);

}  // namespace copepod::coupler
