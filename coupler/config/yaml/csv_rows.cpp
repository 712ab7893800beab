#include <algorithm>
#include <cmath>
#include <fstream>

#include <spdlog/fmt/fmt.h>

#include "config/yaml/keys.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";  // of UTF-8; spreadsheets write it

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The finite number that a text is, spaces around it and a plus sign before it allowed.
std::optional<double> finite_number_in(std::string_view text) {
  text = trimmed(text);
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const std::optional<double> number = number_in<double>(text);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

/// What stands between the fields of a table whose first line this is: spreadsheets write semicolons where the comma is
/// the decimal sign.
char separator_in(std::string_view line) {
  for (const char separator : {';', '\t'})
    if (line.find(separator) != std::string_view::npos) return separator;
  return ',';
}

/// Fields of a line, without quotes and the spaces around them. [RFC 4180]
/// @return nothing if a quote is not closed
std::optional<std::vector<std::string>> fields_of(std::string_view line, char separator) {
  std::vector<std::string> fields(1);
  bool is_quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"') {
      if (is_quoted && i + 1 < line.size() && line[i + 1] == '"')
        fields.back() += line[i++];
      else
        is_quoted = !is_quoted;
    } else if (line[i] == separator && !is_quoted) {
      fields.emplace_back();
    } else {
      fields.back() += line[i];
    }
  }
  if (is_quoted) return {};
  for (std::string& field : fields) field = trimmed(field);
  return fields;
}

/// For a message: what a reader cannot see or a terminal would obey is written as \xNN.
std::string visible(std::string_view text) {
  std::string shown;
  for (const unsigned char c : text) {
    shown += c < 0x20 || c > 0x7E ? fmt::format("\\x{:02X}", c) : std::string(1, static_cast<char>(c));
  }
  return shown;
}

/// Reads one file line by line, and reports the first line that cannot be used.
class CsvReading {
 public:
  CsvReading(Keys& keys, const std::string& key, const std::vector<std::string>& required,
             const std::vector<std::string>& optional, CsvHeader header)
      : keys_(keys), key_(key), required_(required), optional_(optional), header_(header) {}

  std::optional<CsvRows> read() {
    rows_.path = file_beside_case(keys_, key_);
    if (keys_.problems().any_under(keys_.path_of(key_))) return {};
    std::ifstream stream(rows_.path);
    if (!stream || !std::filesystem::is_regular_file(rows_.path)) {
      keys_.reject(key_, "is '" + keys_.raw(key_)->text + "' (" + rows_.path.string() +
                             " cannot be read). Give the path of a CSV file, relative to the case file.");
      return {};
    }
    try {
      for (std::string line; std::getline(stream, line);) {
        ++number_;
        take_line(number_ == 1 && line.starts_with(byte_order_mark) ? line.substr(byte_order_mark.size()) : line);
      }
    } catch (const CaseError& problem) {
      keys_.problems().error_at({rows_.path.string(), number_}, keys_.path_of(key_), problem.what());
      return {};
    }
    if (!rows_.values.empty()) return std::move(rows_);
    const std::string header = header_ == CsvHeader::required ? "a line " + listed(required_, ",") + " and " : "";
    keys_.reject(key_, "has no rows (" + rows_.path.string() + "). Write " + header + "a row of numbers for each " +
                           required_.front() + ".");
    return {};
  }

 private:
  /// @throws CaseError with what is wrong in the line
  void take_line(std::string_view line) {
    if (line.starts_with("\xFF\xFE") || line.starts_with("\xFE\xFF") || line.find('\0') != std::string_view::npos)
      throw CaseError(
          "this is not a table of plain text (the file was saved as UTF-16, or is not text). Save it as CSV in UTF-8.");
    line = trimmed(line);
    if (line.empty() || line.front() == '#') return;
    if (places_.empty()) separator_ = separator_in(line);
    const auto fields = fields_of(line, separator_);
    if (!fields) throw CaseError("a quote is not closed (each field begins and ends on one line). Close it.");
    if (!places_.empty()) return take_row(*fields);
    if (header_ == CsvHeader::required || is_header_of_own_order(*fields)) return take_header(*fields);
    for (std::size_t i = 0; i < required_.size(); ++i) places_.push_back(i);
    const bool has_numbers =
        std::ranges::any_of(*fields, [](const auto& field) { return finite_number_in(field).has_value(); });
    if (has_numbers || fields->size() != required_.size()) take_row(*fields);
  }

  [[nodiscard]] bool is_header_of_own_order(const std::vector<std::string>& names) const {
    return std::ranges::all_of(required_, [&](const auto& name) { return std::ranges::count(names, name) == 1; });
  }

  void take_header(const std::vector<std::string>& names) {
    const std::string columns =
        listed(required_, ",") + (optional_.empty() ? "" : " or with " + listed(optional_, ",") + " too");
    std::vector<std::string> wanted = required_;
    const auto is_there = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
    rows_.has_optional = std::ranges::any_of(optional_, is_there);
    if (rows_.has_optional) wanted.insert(wanted.end(), optional_.begin(), optional_.end());
    for (const std::string& name : names) {
      if (std::ranges::find(wanted, name) == wanted.end())
        throw CaseError("column '" + visible(name) + "' is unknown (the first line names the columns). Write " +
                        columns + ".");
      if (std::ranges::count(names, name) > 1)
        throw CaseError("column '" + name + "' is there twice (which one counts?). Remove one.");
    }
    for (const std::string& name : wanted) {
      if (!is_there(name))
        throw CaseError("column '" + name + "' is missing (the first line names the columns). Write " + columns + ".");
      places_.push_back(std::ranges::find(names, name) - names.begin());
    }
  }

  void take_row(const std::vector<std::string>& fields) {
    if (fields.size() != places_.size())
      throw CaseError("the row has " + std::to_string(fields.size()) + " entries (there are " +
                      std::to_string(places_.size()) + " columns). Give one number for each.");
    std::vector<double> values;
    for (const std::size_t place : places_) {
      const std::optional<double> value = finite_number_in(fields[place]);
      const bool has_comma = fields[place].find(',') != std::string::npos;
      if (!value)
        throw CaseError("'" + visible(fields[place]) + "' is not a finite number (" +
                        (has_comma ? "the decimal sign is a point" : "a row holds numbers only") +
                        "). Write it like 1.0e-6.");
      values.push_back(*value);
    }
    rows_.values.push_back(std::move(values));
    rows_.lines.push_back(number_);
  }

  Keys& keys_;
  const std::string& key_;
  const std::vector<std::string>& required_;
  const std::vector<std::string>& optional_;
  CsvHeader header_;
  char separator_ = ',';
  std::vector<std::size_t> places_;  ///< of the columns in a line
  CsvRows rows_;
  int number_ = 0;
};

}  // namespace

std::filesystem::path file_beside_case(Keys& keys, const std::string& key) {
  std::string name;
  keys.text(key.c_str(), name, "");
  const Origin& origin = keys.raw(key)->origin;
  const auto folder = origin.line > 0 ? std::filesystem::path(origin.source).parent_path() : std::filesystem::path();
  return (folder / name).lexically_normal();
}

std::optional<CsvRows> read_csv_rows(Keys& keys, const std::string& key, const std::vector<std::string>& required,
                                     const std::vector<std::string>& optional, CsvHeader header) {
  return CsvReading(keys, key, required, optional, header).read();
}

}  // namespace copepod::coupler
