#pragma once

#include <array>
#include <charconv>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
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

/// Where a table of a run directory ended at some time, and the checksum of its rows until there.
struct TableEnd {
  std::uint64_t bytes = 0;
  std::uint64_t checksum = 0;

  bool operator==(const TableEnd&) const = default;
};

using TableEnds = std::map<std::string, TableEnd>;  ///< by name of the file

/// A table of a run directory that grows row by row. Only whole rows reach the file, so a run that crashes leaves a
/// readable one.
class TableFile {
 public:
  virtual ~TableFile();

  /// Hands every row so far to the operating system.
  /// @throws StorageError if the disk does not take them
  void flush();
  /// The same, and waits for the disk.
  /// @return where the table ends now
  TableEnd sync();

 protected:
  /// @param end   where to continue the file, without what a run that was interrupted wrote behind it; absent: a new
  ///              one is started
  /// @param head  bytes before the rows
  /// @throws StorageError if the file cannot be written, or is not what it was up to `end`
  TableFile(std::string path, const std::optional<TableEnd>& end, std::uint64_t head = 0);
  /// Adds bytes to a row.
  void append(std::string_view bytes) { buffer_ += bytes; }
  /// The row is whole: it reaches the file at the latest with the first one a second later.
  /// @throws StorageError as `flush`
  void end_row();

  std::function<std::string(std::uint64_t bytes)> make_head_;  ///< for so many bytes of rows, once these are written

 private:
  using Clock = std::chrono::steady_clock;
  void write(std::uint64_t position, std::string_view bytes);
  [[noreturn]] void fail(const std::string& remedy) const;

  std::string path_;
  std::uint64_t head_;
  int file_ = -1;
  std::uint64_t bytes_ = 0;  ///< as in TableEnd
  Checksum checksum_;        ///< of them
  std::string buffer_;       ///< rows behind them
  Clock::time_point flushed_ = Clock::now();
};

/// A table as text.
class CsvFile final : public TableFile {
 public:
  /// @param header  first line of a new file, without its end
  /// @throws StorageError as TableFile, and if the file has another header
  CsvFile(const std::string& path, const std::string& header, const std::optional<TableEnd>& end);

  /// @param row  without its end
  void add(std::string_view row) {
    append(row);
    append("\n");
    end_row();
  }
};

/// Samples in NumPy's format [NEP 1], version 1.0: a head with type and number of the samples, then the samples as they
/// lie in memory. The head is written last, so that readers find what it announces.
class NpyFile final : public TableFile {
 public:
  static constexpr std::uint64_t head_bytes = 1024;  ///< within a page: it is seen whole

  /// @param type          of a sample, as NumPy describes it
  /// @param sample_bytes  its size
  /// @throws StorageError as TableFile, and if the file is of another type
  NpyFile(const std::string& path, const std::string& type, std::uint64_t sample_bytes,
          const std::optional<TableEnd>& end);

  /// @param values  of each field
  void add(std::span<const std::span<const std::byte>> values);
};

/// What is wrong with a table that is to be continued from `end`; empty if nothing is.
std::string find_damage(const std::string& path, const TableEnd& end);

/// Appends a number as the shortest text that reads back to the same bits.
template <typename Number>
void append(std::string& row, Number number) {
  std::array<char, 32> text{};
  row.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr);
}

/// Appends a comma and a field for each number, and for each element of a vector; absent numbers have empty fields.
template <typename... Values>
void append_all(std::string& row, const Values&... values) {
  const auto append_each = [&row](const auto& value) {
    if constexpr (requires { value.begin(); })
      for (const auto number : value) append(row += ',', number);
    else if constexpr (requires { *value; })
      value ? append(row += ',', *value) : row.push_back(',');
    else
      append(row += ',', value);
  };
  (append_each(values), ...);
}

/// A name, in quotes where CSV needs them.
inline std::string csv_field(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string field = "\"";
  for (const char c : name) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}
}  // namespace copepod::coupler
