#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include "config/yaml/document.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

enum class Range { any, positive, not_negative };

/// When a case must have a key. Where it need not, a default applies.
enum class Need {
  never,
  in_some_cases,  ///< its default depends on other keys, so that the schema has none
  always,
};

struct Key {
  Key(const char* name, Need need = Need::never) : name(name), need(need) {}  // NOLINT: reads as a name
  [[nodiscard]] bool is_required() const { return need == Need::always; }
  std::string name;
  Need need;
};

inline Key required(const char* name) { return {name, Need::always}; }

/// A section of the case in which each key is declared once: its name, what it holds, the values that it may have, and
/// what it means. The same calls read the case, write it with every default spelled out (the resolved case), and
/// describe it as JSON schema. A field's value before its key is read is the default, which it keeps where the key is
/// absent or, once that is reported, cannot be used: reading continues and finds every error.
class Keys {
 public:
  using Declare = std::function<void(Keys&)>;

  /// Reads a mapping of the case. Every key that is asked for is known; any other one is an error, reported when this
  /// goes out of scope.
  /// @param mapping  nullptr stands for an empty section
  /// @param path     key path of the section, "" for the top
  Keys(const Value* mapping, std::string path, Problems& problems);
  Keys(const Keys&) = delete;
  Keys& operator=(const Keys&) = delete;
  ~Keys();
  static nlohmann::ordered_json written(const Declare& declare);    ///< a section of the resolved case
  static nlohmann::ordered_json described(const Declare& declare);  ///< schema of a section

  void number(const Key& key, double& value, Range range, const char* description);
  void number(const Key& key, std::optional<double>& value, Range range, const char* description);
  /// One of some words or a number, which `value` holds: a word for an absent number, another for 0.
  void number_or(const Key& key, std::optional<double>& value, Range range, const char* word_of_none,
                 const char* word_of_zero, const std::string& number_of, const char* description);
  void integer(const Key& key, std::int64_t& value, Range range, const char* description);
  void numbers(const Key& key, Eigen::Ref<Eigen::VectorXd> values, const char* description);
  void integers(const Key& key, std::span<std::int64_t> values, Range range, const char* description);
  void text(const Key& key, std::string& value, const char* description);
  /// A text that may name files and be printed on a terminal.
  void name(const Key& key, std::string& value, const char* description);
  void flag(const Key& key, bool& value, const char* description);
  /// A list of texts, or one text.
  /// @param count  of the words; 0: any
  void words(const Key& key, std::vector<std::string>& values, std::size_t count, const char* description);
  /// A list of texts, or one text that is split like a shell would.
  void command(const Key& key, std::vector<std::string>& words, const char* description);
  template <typename E, std::size_t N>
  void choice(const Key& key, E& value, const std::array<Choice<E>, N>& choices, const char* description) {
    std::array<const char*, N> names{};
    std::size_t place = 0;
    for (std::size_t i = 0; i < N; ++i) {
      names[i] = choices[i].name;
      if (choices[i].value == value) place = i;
    }
    value = choices[choose(key, place, names, description)].value;
  }
  /// The key `kind`, which decides which others there are.
  /// @return false where it cannot be used: no other key is to be read then
  template <typename E, std::size_t N>
  bool kind(E& value, const std::array<Choice<E>, N>& choices, const char* description) {
    choice(required("kind"), value, choices, description);
    accepts_all_ = has_errors("kind");
    return !accepts_all_;
  }

  void section(const Key& key, const char* description, const Declare& declare);
  /// A section that may be absent.
  template <typename T>
  void section(const Key& key, std::optional<T>& value, const char* description,
               const std::function<void(Keys&, std::type_identity_t<T>&)>& declare) {
    if (when(has(key.name))) value.emplace();
    if (value) section(key, description, [&](Keys& below) { declare(below, *value); });
  }
  /// Another form of a key, beside the one that is declared already: a section.
  void either(const Key& key, const Declare& declare);
  template <typename T>
  void list(const Key& key, std::vector<T>& items_of_case, const char* description,
            const std::function<void(Keys&, std::type_identity_t<T>&)>& declare) {
    if (resolved_ == nullptr) items_of_case.resize(size_of(key, items_of_case.size()));
    items(key, items_of_case.size(), description,
          [&](Keys& below, std::size_t i) { declare(below, items_of_case[i]); });
  }

  /// Whether keys are to be declared that exist under a condition only: the schema has all of them.
  [[nodiscard]] bool when(bool condition) const { return condition || describes(); }
  /// Whether a key is to be declared that the resolved case has under a condition only.
  [[nodiscard]] bool written_if(bool condition) const { return condition || resolved_ == nullptr; }
  /// A key that is required under a condition only.
  [[nodiscard]] Key needed(const char* name, bool condition = true) const {
    return {name, condition && !describes() ? Need::always : Need::in_some_cases};
  }

  // What a key of its own form does: each of the three where it is asked for.
  [[nodiscard]] bool reads() const { return problems_ != nullptr; }
  [[nodiscard]] nlohmann::ordered_json* resolved() const { return resolved_; }  ///< nullptr unless one is written
  [[nodiscard]] bool describes() const { return schema_ != nullptr; }
  /// Whether a key is given, where a case is read.
  [[nodiscard]] bool has(const std::string& key) { return raw(key) != nullptr; }
  /// The raw value of a key, nullptr if absent.
  const Value* raw(const std::string& key);
  [[nodiscard]] std::size_t size(const std::string& key);  ///< of a list; 0 if absent
  /// Reports that the value of a key which is read cannot be used.
  /// @param problem  "is 3 (why). What to do.": what follows the key's path in the message
  void reject(const std::string& key, const std::string& problem) { reject_if(true, key, problem); }
  void reject_if(bool is_wrong, const std::string& key, const std::string& problem) {
    if (reads() && is_wrong) problems_->reject(path_of(key), problem);
  }
  [[nodiscard]] bool has_errors(const std::string& key) const { return reads() && problems_->any_under(path_of(key)); }
  /// A section whose keys the user invents; nullptr if it is absent, or another value, which is reported.
  const Value* mapping(const std::string& key);
  [[nodiscard]] std::string path_of(const std::string& key) const { return path_.empty() ? key : path_ + "." + key; }
  [[nodiscard]] Problems& problems() { return *problems_; }  ///< where a case is read
  void write(const std::string& key, const auto& value) {
    if (resolved_ != nullptr) (*resolved_)[key] = value;
  }
  void describe(const Key& key, const nlohmann::ordered_json& form, const char* description);
  /// Adds to the description of a key, or of the section: bounds, the pattern of a text, which keys go together.
  void describe_also(const char* key, const nlohmann::ordered_json& more);
  void describe_also(const nlohmann::ordered_json& more);

 private:
  Keys(nlohmann::ordered_json* resolved, nlohmann::ordered_json* schema) : resolved_(resolved), schema_(schema) {}
  const Value* wanted(const Key& key);
  std::optional<double> parse_number(const std::string& path, const Value& value, Range range);
  std::optional<std::int64_t> parse_integer(const std::string& path, const Value& value, Range range);
  void read_list(const Key& key, const auto& parse, auto& numbers);
  void record(const Key& key, const auto& value, const char* description, const auto& form);
  /// @return the place of what is chosen among the names
  std::size_t choose(const Key& key, std::size_t place, std::span<const char* const> names, const char* description);
  void items(const Key& key, std::size_t count, const char* description,
             const std::function<void(Keys&, std::size_t)>& declare);
  /// Of a list that is read; 1 where it is described.
  [[nodiscard]] std::size_t size_of(const Key& key, std::size_t known) {
    return reads() ? size(key.name) : std::max<std::size_t>(known, 1);
  }

  const Value* mapping_ = nullptr;
  std::string path_;
  Problems* problems_ = nullptr;
  std::set<std::string> known_;
  bool accepts_all_ = false;
  nlohmann::ordered_json* resolved_ = nullptr;
  nlohmann::ordered_json* schema_ = nullptr;
};

// Forms of values in a JSON schema.
nlohmann::ordered_json schema_of_number(Range range);
nlohmann::ordered_json schema_of_integer(Range range);
nlohmann::ordered_json schema_of_list(nlohmann::ordered_json item, std::size_t count);  ///< 0: any number of items
/// Of a whole file, a "case" or a "campaign".
nlohmann::ordered_json schema_of_file(const std::string& kind, const char* description, const Keys::Declare& declare);

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
