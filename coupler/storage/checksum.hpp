#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string_view>

namespace copepod::coupler {

/// XXH3 hash (64 bits, seed 0) of bytes that come one after the other.
class Checksum {
 public:
  Checksum();

  void add(std::string_view bytes);
  /// Of all bytes so far; more may follow.
  [[nodiscard]] std::uint64_t value() const;

 private:
  struct State;
  std::unique_ptr<State, void (*)(State*)> state_;
};

/// Of `bytes` bytes of a file, behind the first `skipped`.
/// @throws StorageError if it cannot be read, or is shorter
Checksum checksum_of_start(const std::filesystem::path& file, std::uint64_t bytes, std::uint64_t skipped = 0);

}  // namespace copepod::coupler
