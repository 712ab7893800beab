#pragma once

#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <Eigen/Core>

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
  CsvFile(const std::string& path, const std::string& header, const std::optional<TableEnd>& end);
  ~CsvFile() override;

  /// Adds a row, given without its end, which reaches the file at the latest with the first row a second later.
  /// @throws StorageError as `flush`
  void add(std::string_view row);
  void flush() override;

  /// Of what a file holds up to `end`; empty if it ends before, or cannot be read.
  static std::optional<Checksum> checksum_of_start(const std::string& path, const TableEnd& end);

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
std::string csv_field(const std::string& name);

}  // namespace copepod::coupler
