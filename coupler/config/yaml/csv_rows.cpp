#include "config/yaml/csv_rows.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>

namespace copepod::coupler {
namespace {

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  for (std::size_t start = 0; start <= line.size();) {
    const std::size_t comma = std::min(line.find(',', start), line.size());
    fields.push_back(trimmed(line.substr(start, comma - start)));
    start = comma + 1;
  }
  return fields;
}

std::string joined_by_comma(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ",") + word;
  return text;
}

/// Reads one file line by line, and reports the first line that cannot be used.
class CsvReading {
 public:
  CsvReading(Reader& reader, const std::string& key, const std::vector<std::string>& required,
             const std::vector<std::string>& optional)
      : reader_(reader), key_(key), required_(required), optional_(optional) {
    rows_.path = file_beside_case(reader, key);
  }

  std::optional<CsvRows> read() {
    std::ifstream stream(rows_.path);
    if (!stream || !std::filesystem::is_regular_file(rows_.path)) {
      reader_.reject(key_, "is '" + reader_.text(key_) + "' (" + rows_.path.string() +
                               " cannot be read). Give the path of a CSV file, relative to the case file.");
      return {};
    }
    for (std::string line; std::getline(stream, line);) {
      ++number_;
      const std::string_view content = trimmed(line);
      if (content.empty() || content.front() == '#') continue;
      if (!(places_.empty() ? take_header(content) : take_row(content))) return {};
    }
    if (!rows_.values.empty()) return std::move(rows_);
    reader_.reject(key_, "has no rows (" + rows_.path.string() + "). Write a line " + joined_by_comma(required_) +
                             " and a row of numbers for each.");
    return {};
  }

 private:
  bool report(const std::string& problem) {
    reader_.problems().error_at({rows_.path.string(), number_}, reader_.path_of(key_), problem);
    return false;
  }

  bool take_header(std::string_view line) {
    const std::vector<std::string_view> names = fields_of(line);
    const std::string columns = joined_by_comma(required_) + (optional_.empty() ? "" : " or with ") +
                                joined_by_comma(optional_) + (optional_.empty() ? "" : " too");
    std::vector<std::string> wanted = required_;
    const auto is_there = [&](const std::string& name) { return std::ranges::find(names, name) != names.end(); };
    rows_.has_optional = std::ranges::any_of(optional_, is_there);
    if (rows_.has_optional) wanted.insert(wanted.end(), optional_.begin(), optional_.end());
    for (const std::string_view name : names) {
      if (std::ranges::find(wanted, name) == wanted.end())
        return report("column '" + std::string(name) + "' is unknown (the first line names the columns). Write " +
                      columns + ".");
      if (std::ranges::count(names, name) > 1)
        return report("column '" + std::string(name) + "' is there twice (which one counts?). Remove one.");
    }
    for (const std::string& name : wanted) {
      if (!is_there(name))
        return report("column '" + name + "' is missing (the first line names the columns). Write " + columns + ".");
      places_.push_back(static_cast<std::size_t>(std::ranges::find(names, name) - names.begin()));
    }
    return true;
  }

  bool take_row(std::string_view line) {
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.size() != places_.size())
      return report("the row has " + std::to_string(fields.size()) + " entries (there are " +
                    std::to_string(places_.size()) + " columns). Give one number for each.");
    std::vector<double> values;
    for (const std::size_t place : places_) {
      const std::optional<double> value = number_in(fields[place]);
      if (!value)
        return report("'" + std::string(fields[place]) +
                      "' is not a finite number (a row holds numbers only). Write "
                      "it like 1.0e-6.");
      values.push_back(*value);
    }
    rows_.values.push_back(std::move(values));
    rows_.lines.push_back(number_);
    return true;
  }

  Reader& reader_;
  const std::string& key_;
  const std::vector<std::string>& required_;
  const std::vector<std::string>& optional_;
  std::vector<std::size_t> places_;  ///< of the columns in a line
  CsvRows rows_;
  int number_ = 0;
};

}  // namespace

std::filesystem::path file_beside_case(Reader& reader, const std::string& key) {
  const std::filesystem::path name = reader.text(key);
  const Origin& origin = reader.raw(key)->origin;
  const auto folder = origin.line > 0 ? std::filesystem::path(origin.source).parent_path() : std::filesystem::path();
  return (folder / name).lexically_normal();
}

std::optional<double> number_in(std::string_view text) {
  text = trimmed(text);
  double number = 0.0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool is_number = error == std::errc{} && stop == text.data() + text.size() && std::isfinite(number);
  return is_number ? std::optional(number) : std::nullopt;
}

std::optional<CsvRows> read_csv_rows(Reader& reader, const std::string& key, const std::vector<std::string>& required,
                                     const std::vector<std::string>& optional) {
  CsvReading reading(reader, key, required, optional);
  if (reader.problems().any_under(reader.path_of(key))) return {};
  return reading.read();
}

}  // namespace copepod::coupler
