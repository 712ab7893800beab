#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
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

/// A table of a run directory that grows: what both of its forms do.
class TableFile {
 public:
  virtual ~TableFile();

  /// Hands every row so far to the operating system.
  /// @throws StorageError if the disk does not take them
  virtual void flush() = 0;
  /// The same, and waits for the disk.
  /// @return where the table ends now
  TableEnd sync();

 protected:
  /// @param end  where to continue the file of a run that was interrupted; absent: a new one is started
  /// @throws StorageError if the file cannot be written, or is not what it was up to `end`
  TableFile(std::string path, const std::optional<TableEnd>& end);
  void write(std::uint64_t position, std::string_view bytes);
  void resize(std::uint64_t bytes);
  [[noreturn]] void fail(const std::string& remedy) const;
  /// Readers see a row at the latest with the first one a second later.
  [[nodiscard]] bool is_due() const { return Clock::now() - flushed_ >= std::chrono::seconds(1); }

  using Clock = std::chrono::steady_clock;
  std::string path_;
  int file_ = -1;
  std::uint64_t bytes_ = 0;  ///< as in TableEnd
  Checksum checksum_;        ///< of them
  Clock::time_point flushed_ = Clock::now();
};

/// What is wrong with a table that is to be continued from `end`; empty if nothing is.
std::string find_damage(const std::string& path, const TableEnd& end);

}  // namespace copepod::coupler
