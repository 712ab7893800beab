#pragma once

#include <array>
#include <charconv>
#include <chrono>
#include <functional>
#include <string>
#include <string_view>

#include <Eigen/Core>

namespace copepod::coupler {

/// A table of a run directory that grows row by row. Only whole lines reach the file, so a run that crashes leaves a
/// readable one.
class CsvFile {
 public:
  /// @param header  first line, without its end
  /// @param keep    of an existing table with this header, asked for each row in order: whether it stays. The file is
  ///                cut after the last one that does; absent: a new file is started
  /// @throws StorageError if the file cannot be written
  CsvFile(const std::string& path, const std::string& header, const std::function<bool(std::string_view row)>& keep);
  CsvFile(const CsvFile&) = delete;
  CsvFile& operator=(const CsvFile&) = delete;
  ~CsvFile();

  /// Adds a row, given without its end, which reaches the file at the latest with the first row a second later.
  /// @throws StorageError as `flush`
  void add(std::string_view row);
  /// Hands every row so far to the operating system.
  /// @throws StorageError if the disk does not take them
  void flush();
  /// The same, and waits for the disk.
  void sync();

 private:
  void keep_rows(const std::function<bool(std::string_view)>& keep);

  std::string path_;
  std::string header_;
  int file_ = -1;
  std::string buffer_;
  std::chrono::steady_clock::time_point flushed_;
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
