#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "config/yaml/reader.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

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
/// describe it as JSON schema. A field's value before its key is read is the default.
class Keys {
 public:
  using Declare = std::function<void(Keys&)>;

  static Keys reading(Reader& reader) { return {&reader, nullptr, nullptr}; }
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
  void name(const Key& key, std::string& value, const char* description);  ///< see Reader::name
  void flag(const Key& key, bool& value, const char* description);
  /// @param count  of the words; 0: any
  void words(const Key& key, std::vector<std::string>& values, std::size_t count, const char* description);
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
    if (reader_ == nullptr || !reader_->problems().any_under(reader_->path_of("kind"))) return true;
    reader_->accept_all();
    return false;
  }

  void section(const Key& key, const char* description, const Declare& declare);
  /// A section that may be absent.
  template <typename T>
  void section(const Key& key, std::optional<T>& value, const char* description,
               const std::function<void(Keys&, std::type_identity_t<T>&)>& declare) {
    if (describes() || (reader_ != nullptr && reader_->has(key.name))) value.emplace();
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
  [[nodiscard]] Reader* reader() const { return reader_; }                      ///< nullptr unless a case is read
  [[nodiscard]] nlohmann::ordered_json* resolved() const { return resolved_; }  ///< nullptr unless one is written
  [[nodiscard]] bool describes() const { return schema_ != nullptr; }
  [[nodiscard]] bool reads(const char* key) const { return reader_ != nullptr && reader_->has(key); }
  /// Reports that a key which is read cannot be used, if `is_wrong`.
  /// @param problem  as for Reader::reject
  void reject_if(bool is_wrong, const std::string& key, const std::string& problem) {
    if (reader_ != nullptr && is_wrong) reader_->reject(key, problem);
  }
  void write(const char* key, const nlohmann::ordered_json& value) {
    if (resolved_ != nullptr) (*resolved_)[key] = value;
  }
  void describe(const Key& key, const nlohmann::ordered_json& form, const char* description);
  /// Adds to the description of a key, or of the section: bounds, the pattern of a text, which keys go together.
  void describe_also(const char* key, const nlohmann::ordered_json& more);
  void describe_also(const nlohmann::ordered_json& more);

 private:
  Keys(Reader* reader, nlohmann::ordered_json* resolved, nlohmann::ordered_json* schema)
      : reader_(reader), resolved_(resolved), schema_(schema) {}
  /// @return the place of what is chosen among the names
  std::size_t choose(const Key& key, std::size_t place, std::span<const char* const> names, const char* description);
  void items(const Key& key, std::size_t count, const char* description,
             const std::function<void(Keys&, std::size_t)>& declare);
  /// Of a list that is read; 1 where it is described.
  [[nodiscard]] std::size_t size_of(const Key& key, std::size_t known) const {
    return reader_ != nullptr ? reader_->size(key.name) : std::max<std::size_t>(known, 1);
  }

  Reader* reader_;
  nlohmann::ordered_json* resolved_;
  nlohmann::ordered_json* schema_;
};

// Forms of values in a JSON schema.
nlohmann::ordered_json schema_of_number(Range range);
nlohmann::ordered_json schema_of_integer(Range range);
nlohmann::ordered_json schema_of_list(nlohmann::ordered_json item, std::size_t count);  ///< 0: any number of items
/// Of a whole file, a "case" or a "campaign".
nlohmann::ordered_json schema_of_file(const std::string& kind, const char* description, const Keys::Declare& declare);

}  // namespace copepod::coupler
