#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

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

  static Value mapping();

  /// Appends an entry to a mapping.
  void add(const std::string& key, Value item);

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

/// What a scalar means depends on the key: all become strings; or those that read as numbers become numbers.
enum class Scalars { as_text, as_numbers };
nlohmann::ordered_json to_json(const Value& value, Scalars scalars = Scalars::as_text);

}  // namespace copepod::coupler
