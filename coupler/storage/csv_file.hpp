#pragma once

#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

#include "contract/errors.hpp"
#include "storage/checksum.hpp"

namespace copepod::coupler {

/// A table of a run directory that grows row by row. Only whole lines reach the file, so a run that crashes leaves a
/// readable one.
class CsvFile final : public TableFile {
 public:
  /// @param header  first line of a new file, without its end
  /// @param end     where to continue an existing one, without what a run that was interrupted wrote behind it; absent:
  ///                a new file is started
  /// @throws StorageError if the file cannot be written, or is not what it was up to `end`
  CsvFile(const std::string& path, const std::string& header, const std::optional<TableEnd>& end)
      : TableFile(path, end) {
    if (end)
      checksum_ = coupler::checksum_of_start(path, bytes_);
    else
      buffer_ = header + '\n';
    resize(bytes_);
    flush();
  }
  ~CsvFile() override {
    try {
      flush();
    } catch (const Error&) {
      // The run is failing already; whole lines written before stay as they are.
    }
  }

  /// Adds a row, given without its end, which reaches the file at the latest with the first row a second later.
  /// @throws StorageError as `flush`
  void add(std::string_view row) {
    buffer_.append(row) += '\n';
    constexpr std::size_t most_buffered = std::size_t{1} << 20;
    if (is_due() || buffer_.size() > most_buffered) flush();
  }
  void flush() override {
    write(bytes_, buffer_);
    checksum_.add(buffer_);
    bytes_ += buffer_.size();
    buffer_.clear();
    flushed_ = Clock::now();
  }

  /// Of what a file holds up to `end`; empty if it ends before, or cannot be read.
  static std::optional<Checksum> checksum_of_start(const std::string& path, const TableEnd& end) try {
    return coupler::checksum_of_start(path, end.bytes);
  } catch (const StorageError&) {
    return std::nullopt;
  }

 private:
  std::string buffer_;
};

/// Appends a number as the shortest text that reads back to the same bits.
template <typename Number>
void append(std::string& row, Number number) {
  std::array<char, 32> text{};
  row.append(text.data(), std::to_chars(text.data(), text.data() + text.size(), number).ptr);
}

/// Appends a comma and a field for each element of a vector.
template <typename Column>
void append_all(std::string& row, const Eigen::MatrixBase<Column>& column) {
  for (Eigen::Index i = 0; i < column.size(); ++i) {
    row += ',';
    append(row, column[i]);
  }
}

/// A name, in quotes where CSV needs them.
inline std::string csv_field(const std::string& name) {
  if (name.find_first_of(",\"\r\n") == std::string::npos) return name;
  std::string field = "\"";
  for (const char c : name) field += c == '"' ? std::string("\"\"") : std::string(1, c);
  return field + "\"";
}

}  // namespace copepod::coupler
