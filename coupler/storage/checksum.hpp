#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace copepod::coupler {

/// XXH3 hash (64 bits, seed 0) of bytes that come one after the other.
class Checksum {
 public:
  Checksum();
  Checksum(Checksum&&) noexcept;
  Checksum& operator=(Checksum&&) noexcept;
  ~Checksum();

  void add(std::string_view bytes);
  /// Of all bytes so far; more may follow.
  [[nodiscard]] std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of the first `bytes` bytes of a file.
/// @throws StorageError if it cannot be read, or is shorter
Checksum checksum_of_start(const std::filesystem::path& file, std::uint64_t bytes);

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
