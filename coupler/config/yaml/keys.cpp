#include "config/yaml/keys.hpp"

#include <algorithm>
#include <cctype>
#include <utility>

#include <nlohmann/json.hpp>

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

const ordered_json form_of_text{{"type", "string"}};

/// What holds without the key; nothing where it is required.
template <typename Value>
std::optional<Value> default_of(const Key& key, const Value& value) {
  return key.is_required() ? std::nullopt : std::optional(value);
}

ordered_json with_default(ordered_json schema, const ordered_json& value, const Key& key) {
  if (key.need == Need::never) schema["default"] = value;
  return schema;
}

/// What holds for either of two forms of a key: all keys below, of which those of both are required.
void merge(ordered_json& known, const ordered_json& other) {
  for (const auto& [key, value] : other.items()) {
    if (key == "required") continue;
    if (!known.contains(key))
      known[key] = value;
    else if (value.is_object())
      merge(known[key], value);
  }
  if (!known.contains("required")) return;
  const ordered_json others = other.value("required", ordered_json::array());
  ordered_json both = ordered_json::array();
  for (const ordered_json& name : known["required"])
    if (std::ranges::find(others, name) != others.end()) both.push_back(name);
  known["required"] = both;
  if (both.empty()) known.erase("required");
}

}  // namespace

ordered_json schema_of_number(Range range) {
  ordered_json schema{{"type", "number"}};
  if (range == Range::positive) schema["exclusiveMinimum"] = 0;
  if (range == Range::not_negative) schema["minimum"] = 0;
  return schema;
}

ordered_json schema_of_integer(Range range) {
  ordered_json schema{{"type", "integer"}};
  if (range != Range::any) schema["minimum"] = range == Range::positive ? 1 : 0;
  return schema;
}

ordered_json schema_of_list(ordered_json item, std::size_t count) {
  ordered_json schema{{"type", "array"}, {"items", std::move(item)}};
  if (count > 0) schema.update({{"minItems", count}, {"maxItems", count}});
  return schema;
}

ordered_json schema_of_file(const std::string& kind, const char* description, const Keys::Declare& declare) {
  ordered_json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                      {"$id", kind + ".schema.json"},
                      {"title", "Copepod " + kind},
                      {"description", description}};
  schema.update(Keys::described(declare));
  return schema;
}

ordered_json Keys::written(const Declare& declare) {
  ordered_json section = ordered_json::object();
  Keys keys(nullptr, &section, nullptr);
  declare(keys);
  return section;
}

ordered_json Keys::described(const Declare& declare) {
  ordered_json schema{{"type", "object"}, {"additionalProperties", false}, {"properties", ordered_json::object()}};
  Keys keys(nullptr, nullptr, &schema);
  declare(keys);
  return schema;
}

void Keys::describe(const Key& key, const ordered_json& form, const char* description) {
  if (!describes()) return;
  ordered_json described{{"description", description}};
  described.update(form);
  ordered_json& properties = (*schema_)["properties"];
  if (properties.contains(key.name)) return merge(properties[key.name], described);
  properties[key.name] = std::move(described);
  if (key.is_required()) (*schema_)["required"].push_back(key.name);
}

void Keys::describe_also(const char* key, const ordered_json& more) {
  if (describes()) (*schema_)["properties"][key].update(more);
}

void Keys::describe_also(const ordered_json& more) {
  if (describes()) schema_->update(more);
}

void Keys::number(const Key& key, double& value, Range range, const char* description) {
  if (reader_ != nullptr) value = reader_->number(key.name, range, default_of(key, value));
  if (resolved_ != nullptr) (*resolved_)[key.name] = value;
  if (describes()) describe(key, with_default(schema_of_number(range), value, key), description);
}

void Keys::number(const Key& key, std::optional<double>& value, Range range, const char* description) {
  if (reader_ != nullptr && reader_->has(key.name)) value = reader_->number(key.name, range);
  if (resolved_ != nullptr && value) (*resolved_)[key.name] = *value;
  describe(key, schema_of_number(range), description);
}

void Keys::number_or(const Key& key, std::optional<double>& value, Range range, const char* word_of_none,
                     const char* word_of_zero, const std::string& number_of, const char* description) {
  const std::string zero = word_of_zero;
  if (reader_ != nullptr) {
    const Value* given = reader_->raw(key.name);
    const std::string word = given == nullptr ? word_of_none : given->text;
    value.reset();
    if (!zero.empty() && word == zero) {
      value = 0.0;
    } else if (given != nullptr && word != word_of_none) {
      if (given->kind == Value::Kind::scalar && std::isalpha(static_cast<unsigned char>(word.front())) != 0)
        reader_->reject(key.name, "is '" + word + "' (known: " + word_of_none + (zero.empty() ? "" : ", " + zero) +
                                      "). Write one of these, or a number of " + number_of + ".");
      else
        value = reader_->number(key.name, range);
    }
  }
  if (resolved_ != nullptr)
    (*resolved_)[key.name] = !value                           ? ordered_json(word_of_none)
                             : *value == 0.0 && !zero.empty() ? ordered_json(zero)
                                                              : ordered_json(*value);
  ordered_json words{word_of_none};
  if (!zero.empty()) words.push_back(zero);
  describe(key, {{"anyOf", {{{"enum", words}}, schema_of_number(range)}}, {"default", word_of_none}}, description);
}

void Keys::integer(const Key& key, std::int64_t& value, Range range, const char* description) {
  if (reader_ != nullptr) value = reader_->integer(key.name, range, default_of(key, value));
  if (resolved_ != nullptr) (*resolved_)[key.name] = value;
  if (describes()) describe(key, with_default(schema_of_integer(range), value, key), description);
}

void Keys::numbers(const Key& key, Eigen::Ref<Eigen::VectorXd> values, const char* description) {
  if (reader_ != nullptr) values = reader_->numbers(key.name, values.size(), default_of(key, Eigen::VectorXd(values)));
  if (resolved_ != nullptr) (*resolved_)[key.name] = values;
  if (!describes()) return;
  const ordered_json form = schema_of_list(schema_of_number(Range::any), static_cast<std::size_t>(values.size()));
  describe(key, with_default(form, values, key), description);
}

void Keys::integers(const Key& key, std::span<std::int64_t> values, Range range, const char* description) {
  const std::vector<std::int64_t> known(values.begin(), values.end());
  if (reader_ != nullptr)
    std::ranges::copy(reader_->integers(key.name, known.size(), range, default_of(key, known)), values.begin());
  if (resolved_ != nullptr) (*resolved_)[key.name] = known;
  if (!describes()) return;
  describe(key, with_default(schema_of_list(schema_of_integer(range), known.size()), known, key), description);
}

void Keys::text(const Key& key, std::string& value, const char* description) {
  if (reader_ != nullptr) value = reader_->text(key.name, default_of(key, value));
  if (resolved_ != nullptr) (*resolved_)[key.name] = value;
  describe(key, form_of_text, description);
}

void Keys::name(const Key& key, std::string& value, const char* description) {
  if (reader_ != nullptr) value = reader_->name(key.name, default_of(key, value));
  if (resolved_ != nullptr) (*resolved_)[key.name] = value;
  describe(key, form_of_text, description);
}

void Keys::words(const Key& key, std::vector<std::string>& values, std::size_t count, const char* description) {
  if (reader_ != nullptr) values = reader_->words(key.name);
  if (resolved_ != nullptr) (*resolved_)[key.name] = values;
  if (describes()) describe(key, schema_of_list(form_of_text, count), description);
}

void Keys::command(const Key& key, std::vector<std::string>& words, const char* description) {
  if (reader_ != nullptr) words = reader_->command(key.name);
  if (resolved_ != nullptr) (*resolved_)[key.name] = words;
  if (describes()) describe(key, {{"anyOf", {form_of_text, schema_of_list(form_of_text, 0)}}}, description);
}

void Keys::flag(const Key& key, bool& value, const char* description) {
  constexpr std::array names{"false", "true"};
  if (describes()) return describe(key, with_default({{"type", "boolean"}}, value, key), description);
  value = choose(key, value ? 1 : 0, names, description) == 1;
}

std::size_t Keys::choose(const Key& key, std::size_t place, std::span<const char* const> names,
                         const char* description) {
  if (resolved_ != nullptr) (*resolved_)[key.name] = names[place];
  describe(key, with_default({{"enum", names}}, names[place], key), description);
  if (reader_ == nullptr) return place;
  const std::size_t found = reader_->choose(key.name, {names.begin(), names.end()}, key.is_required());
  return found < names.size() ? found : place;
}

void Keys::section(const Key& key, const char* description, const Declare& declare) {
  if (reader_ != nullptr) {
    Reader below = reader_->section(key.name);
    Keys keys = reading(below);
    declare(keys);
  }
  if (resolved_ != nullptr) (*resolved_)[key.name] = written(declare);
  if (describes()) describe(key, described(declare), description);
}

void Keys::either(const Key& key, const Declare& declare) {
  if (!describes()) return section(key, "", declare);
  ordered_json& known = (*schema_)["properties"][key.name];
  ordered_json both{{"description", known["description"]}};
  known.erase("description");
  both["anyOf"] = {std::move(known), described(declare)};
  known = std::move(both);
}

void Keys::items(const Key& key, std::size_t count, const char* description,
                 const std::function<void(Keys&, std::size_t)>& declare) {
  if (resolved_ != nullptr) (*resolved_)[key.name] = ordered_json::array();
  for (std::size_t i = 0; i < count; ++i) {
    const auto declare_item = [&](Keys& keys) { declare(keys, i); };
    if (reader_ != nullptr) {
      Reader below = reader_->item(key.name, i);
      Keys keys = reading(below);
      declare_item(keys);
    }
    if (resolved_ != nullptr) (*resolved_)[key.name].push_back(written(declare_item));
    if (describes() && i == 0) describe(key, schema_of_list(described(declare_item), 0), description);
  }
}

}  // namespace copepod::coupler
