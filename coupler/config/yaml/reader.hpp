#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "config/yaml/document.hpp"

namespace copepod::coupler {

enum class Range { any, positive, not_negative };

/// Reads one mapping of the case. Every key that is asked for is known; any other key in the mapping is an
/// error, reported when the reader goes out of scope. A value that cannot be used is reported and replaced by
/// its default, so that reading continues and finds every error.
class Reader {
 public:
  /// @param mapping  nullptr stands for an empty section
  /// @param path     key path of the section, "" for the top
  Reader(const Value* mapping, std::string path, Problems& problems);
  Reader(const Reader&) = delete;
  Reader& operator=(const Reader&) = delete;
  ~Reader();

  [[nodiscard]] bool has(const std::string& key) { return raw(key) != nullptr; }

  /// Without `otherwise` the key is required.
  double number(const std::string& key, Range range, std::optional<double> otherwise = {});
  std::int64_t integer(const std::string& key, Range range, std::optional<std::int64_t> otherwise = {});
  std::string text(const std::string& key, const std::optional<std::string>& otherwise = {});
  /// A text that may name files and be printed on a terminal.
  std::string name(const std::string& key, const std::optional<std::string>& otherwise = {});
  Eigen::VectorXd numbers(const std::string& key, Eigen::Index size,
                          const std::optional<Eigen::VectorXd>& otherwise = {});
  std::vector<std::int64_t> integers(const std::string& key, std::size_t size, Range range,
                                     const std::optional<std::vector<std::int64_t>>& otherwise = {});
  std::vector<std::string> words(const std::string& key);    ///< a list of texts, or one text; empty if absent
  std::vector<std::string> command(const std::string& key);  ///< a list, or one text split like a shell would
  /// @return the place among the names, their number where the value cannot be used or is absent
  std::size_t choose(const std::string& key, const std::vector<std::string>& names, bool required);

  /// Reader of a section; an absent one reads as empty, so that all its defaults apply.
  Reader section(const std::string& key) { return {raw(key), path_of(key), problems_}; }
  /// Reader of an item of the list `key`.
  Reader item(const std::string& key, std::size_t index) {
    return {&raw(key)->items[index], path_of(key) + "." + std::to_string(index), problems_};
  }
  [[nodiscard]] std::size_t size(const std::string& key);  ///< of a list; 0 if absent
  /// The raw value of a key, nullptr if absent.
  const Value* raw(const std::string& key);
  /// Reports that the value of a key cannot be used.
  /// @param problem  "is 3 (why). What to do.": what follows the key's path in the message
  void reject(const std::string& key, const std::string& problem) { problems_.reject(path_of(key), problem); }
  /// Marks every key of the mapping as known: for sections whose keys the user invents.
  void accept_all() { accepts_all_ = true; }

  [[nodiscard]] std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  [[nodiscard]] Problems& problems() { return problems_; }

 private:
  const Value* wanted(const std::string& key, bool required);
  std::optional<double> parse_number(const std::string& path, const Value& value, Range range);
  std::optional<std::int64_t> parse_integer(const std::string& path, const Value& value, Range range);
  void read_list(const std::string& key, bool required, const auto& parse, auto& numbers);
  const Value* wanted_list(const std::string& key, std::size_t size, bool required);

  const Value* mapping_;
  std::string path_;
  Problems& problems_;
  std::set<std::string> known_;
  bool accepts_all_ = false;
};

/// What a user may have meant by a key that a section does not have: the same quantity in another unit or spelling, or
/// by another of its names; or a key of another section.
/// @param known      keys of the section
/// @param elsewhere  paths of all keys, as in docs/case_keys.md
/// @return "Did you mean …?", "It is a key of …." or "Known here: …."
std::string hint_for(const std::string& key, const std::vector<std::string>& known,
                     const std::vector<std::string>& elsewhere);

/// Splits a command like a shell would: spaces separate, quotes and backslashes keep together.
/// @throws CaseError if a quote is not closed
std::vector<std::string> split_command(const std::string& command);

}  // namespace copepod::coupler
