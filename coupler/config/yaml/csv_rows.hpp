#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/yaml/keys.hpp"

namespace copepod::coupler {

/// Whether the first line of a file must name its columns. Where it may be missing, the required columns stand in their
/// order, and a first line of other words is left out.
enum class CsvHeader { required, optional };

/// Numbers of a CSV file.
struct CsvRows {
  std::filesystem::path path;
  std::vector<std::vector<double>> values;  ///< of each row, in the order in which the columns were asked for
  std::vector<int> lines;                   ///< of each row in the file, counted from 1
  bool has_optional = false;                ///< whether the optional columns are there, after the others
};

/// The file that a key names: where a case file names it, a relative path starts in the folder of that file.
std::filesystem::path file_beside_case(Keys& keys, const std::string& key);

/// Reads the file that a key names as spreadsheets write it: fields between commas, semicolons or tabs, with or without
/// quotes and byte-order mark; blank lines and those that start with # are left out. What cannot be used is reported
/// with its line.
/// @param required  columns in any order
/// @param optional  columns of which all are there or none
std::optional<CsvRows> read_csv_rows(Keys& keys, const std::string& key, const std::vector<std::string>& required,
                                     const std::vector<std::string>& optional = {},
                                     CsvHeader header = CsvHeader::required);

}  // namespace copepod::coupler
