#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "contract/errors.hpp"

namespace copepod::coupler {

/// Where a value was written: a file with its line, or the command line (line 0).
struct Origin {
  std::string source;
  int line = 0;
};

/// "file:line", or the source alone where there is no line.
std::string to_string(const Origin& origin);

/// A node of the case: null, scalar, sequence or mapping, and where it was written.
/// Scalars keep their text, so that the reader decides what it means and a message can quote it.
struct Value {
  enum class Kind { null, scalar, sequence, mapping };
  struct Entry;

  Kind kind = Kind::null;
  std::string text;            ///< of a scalar
  std::vector<Value> items;    ///< of a sequence
  std::vector<Entry> entries;  ///< of a mapping, in written order
  Origin origin;

  [[nodiscard]] const Value* find(std::string_view key) const;  ///< nullptr if not a mapping or not there
  [[nodiscard]] Value* find(std::string_view key);
};

struct Value::Entry {
  std::string key;
  Origin key_origin;
  Value value;
};

/// Shortest decimal text that reads back to the same bits.
std::string shortest_text(double number);

/// What a scalar means depends on the key: all become strings; or numbers and truth values, where they read as such.
enum class Scalars { as_text, as_numbers };
nlohmann::ordered_json to_json(const Value& value, Scalars scalars = Scalars::as_text);

/// The case file is unusable; carries every error found, one line each: "file:line: error: problem (why).
/// What to do."
class CaseInvalid : public CaseError {
 public:
  explicit CaseInvalid(std::vector<std::string> lines);
  CaseInvalid(const Origin& origin, const std::string& message);
  [[nodiscard]] const std::vector<std::string>& lines() const { return lines_; }

 private:
  std::vector<std::string> lines_;
};

/// Reads YAML into a tree of values with their line numbers.
/// @param start  the path of the file, with line 1; or the option that the text came from, which has no lines (0)
/// @throws CaseInvalid with file:line if the text is not YAML, is too large, or repeats a key
Value parse_yaml(const std::string& text, const Origin& start);

/// YAML text of a tree; parse_yaml gives back an equal tree.
std::string to_yaml(const nlohmann::ordered_json& value);

/// The case as written, with parameter set and command line applied; locates every key path in the file.
///
/// A key path joins keys and list positions with dots: "swimmers.0.spring.stiffness_N_per_m". Where a list
/// holds mappings with a `name`, the name may stand for the position.
class Document {
 public:
  /// Reads `file`, applies the chosen parameter set, then `overrides` ("key.path=value", value in YAML).
  /// @throws CaseInvalid if the file cannot be read, is not a YAML mapping, or an override has no place to go
  static Document load(const std::string& file, const std::vector<std::string>& overrides);

  /// The same from text; `source` names it in messages.
  static Document parse(const std::string& text, const std::string& source, const std::vector<std::string>& overrides);

  /// The same case with one more assignment for each entry, whose key is a key path; values keep their origins.
  [[nodiscard]] Document with(const std::vector<Value::Entry>& assignments) const;

  [[nodiscard]] const Value& root() const { return root_; }

  /// Where `path` was written; for a path that is not there, where the nearest section around it was.
  [[nodiscard]] Origin locate(const std::string& path) const;

 private:
  Document(Value written, std::vector<Value::Entry> assignments);
  void apply_parameter_set(bool chosen_by_assignment);
  void assign(const std::string& path, Value value);

  Value written_;
  std::vector<Value::Entry> assignments_;
  Value root_;  ///< as written, with parameter set and assignments applied
};

/// Collects what is wrong with a case, so that one look shows every error and not only the first.
/// Places are given as key paths ("swimmers.0.beads.1.radius_m"); the document has their lines.
class Problems {
 public:
  using AllKeys = const std::vector<std::string>& (*)();
  /// @param all_keys  paths of all keys that a document may have, for hints; nullptr: unknown
  explicit Problems(const Document& document, AllKeys all_keys = nullptr) : document_(document), all_keys_(all_keys) {}

  /// Below swarm.template, which stands for many swimmers, the first of several at one place that differ in names and
  /// numbers only stands for all of them.
  /// @param message  "problem (why). What to do."
  void error(const std::string& path, const std::string& message);
  /// The same of the value at `path`.
  /// @param problem  "is 3 (why). What to do.": what follows the path in the message
  void reject(const std::string& path, const std::string& problem) { error(path, path + " " + problem); }
  void error_at(const Origin& origin, const std::string& path, const std::string& message) {
    errors_.push_back({origin, path, to_string(origin) + ": error: " + message});
  }
  /// The first of several that differ in names and numbers only stands for all of them.
  void warning(const std::string& path, const std::string& message);
  void warn(const std::string& path, const std::string& problem) { warning(path, path + " " + problem); }

  /// Whether an error was found at or below `path`; checks that build on a section look here first.
  [[nodiscard]] bool any_under(const std::string& path) const;
  [[nodiscard]] bool any() const { return !errors_.empty(); }
  [[nodiscard]] std::vector<std::string> warnings() const;
  [[nodiscard]] std::vector<std::string> all_keys() const {
    return all_keys_ == nullptr ? std::vector<std::string>() : all_keys_();
  }

  /// @throws CaseInvalid if there is any error; lines in the order of the file
  void throw_if_any() const;

 private:
  struct Entry {
    Origin origin;
    std::string path;
    std::string line;
  };
  const Document& document_;
  AllKeys all_keys_;
  std::vector<Entry> errors_;
  struct Warning {
    std::string line;
    std::size_t others;  ///< of its kind
  };
  std::vector<Warning> warnings_;
  std::map<std::string, std::size_t> kinds_;  ///< where the warning of a kind is
  std::set<std::string> kinds_of_template_;   ///< of errors, with their places
};

}  // namespace copepod::coupler
