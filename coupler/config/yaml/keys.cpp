#include "config/yaml/keys.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

const ordered_json form_of_text{{"type", "string"}};

std::string quoted(const Value& value) {
  const std::array<std::string, 4> kinds{"nothing", "'" + value.text + "'", "a list", "a section"};
  return kinds[static_cast<std::size_t>(value.kind)];
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

Keys::Keys(const Value* mapping, std::string path, Problems& problems)
    : mapping_(mapping), path_(std::move(path)), problems_(&problems) {
  if (mapping_ == nullptr || mapping_->kind == Value::Kind::mapping) return;
  if (mapping_->kind != Value::Kind::null) {
    problems_->reject(path_, "is " + quoted(*mapping_) + " (a section is needed). Write `key: value` lines below it.");
  }
  mapping_ = nullptr;
}

Keys::~Keys() {
  if (mapping_ == nullptr || accepts_all_) return;
  const std::vector<std::string> known(known_.begin(), known_.end());
  for (const Value::Entry& entry : mapping_->entries) {
    if (known_.contains(entry.key)) continue;
    const std::string where = path_.empty() ? "at the top of the case" : "in " + path_;
    problems_->error_at(entry.key_origin, path_of(entry.key),
                        "key '" + entry.key + "' is unknown (nothing " + where + " has this name). " +
                            hint_for(entry.key, known, problems_->all_keys()));
  }
}

const Value* Keys::raw(const std::string& key) {
  if (reads()) known_.insert(key);
  const Value* value = mapping_ == nullptr ? nullptr : mapping_->find(key);
  return value == nullptr || value->kind == Value::Kind::null ? nullptr : value;
}

const Value* Keys::mapping(const std::string& key) {
  if (!has(key)) return nullptr;
  Keys below(raw(key), path_of(key), *problems_);
  return std::exchange(below.mapping_, nullptr);  // none of its keys is unknown
}

const Value* Keys::wanted(const Key& key) {
  const Value* value = raw(key.name);
  if (value == nullptr && key.is_required())
    reject(key.name, "is missing (the case cannot run without it). Add `" + key.name + ": …`.");
  return value;
}

std::optional<double> Keys::parse_number(const std::string& path, const Value& value, Range range) {
  const std::string_view text = value.text;
  const std::optional<double> number = number_in<double>(text.substr(text.starts_with('+') ? 1 : 0));
  if (value.kind != Value::Kind::scalar || !number || !std::isfinite(*number)) {
    problems_->reject(path, "is " + quoted(value) + " (a finite number is needed). Write it like 1.0e-6.");
    return {};
  }
  if ((range == Range::positive && *number <= 0) || (range == Range::not_negative && *number < 0)) {
    problems_->reject(path, "is " + value.text + " (it must " +
                                (range == Range::positive ? "be positive" : "not be negative") +
                                "). Check sign and value.");
    return {};
  }
  return number;
}

std::optional<std::int64_t> Keys::parse_integer(const std::string& path, const Value& value, Range range) {
  const std::optional<std::int64_t> number = number_in<std::int64_t>(value.text);
  if (value.kind != Value::Kind::scalar || !number) {
    problems_->reject(path, "is " + quoted(value) + " (a whole number is needed). Write it like 1000.");
    return {};
  }
  constexpr std::int64_t largest = 1'000'000'000'000'000;  // sums and differences of two stay countable
  if (*number > largest || *number < -largest) {
    problems_->reject(path, "is " + value.text + " (values in a case do not exceed 10^15). Check its digits.");
    return {};
  }
  return parse_number(path, value, range) ? number : std::nullopt;
}

/// @param parse  what is parsed of an item; what cannot be used keeps its value in `numbers`
void Keys::read_list(const Key& key, const auto& parse, auto& numbers) {
  const Value* list = wanted(key);
  if (list == nullptr) return;
  const auto size = static_cast<std::size_t>(numbers.size());
  const bool is_list = list->kind == Value::Kind::sequence;
  if (!is_list || list->items.size() != size)
    return reject(key.name,
                  (is_list ? "has " + std::to_string(list->items.size()) + " entries" : "is " + quoted(*list)) +
                      " (a list of " + std::to_string(size) + " is needed). Write it in brackets: [a, b, …].");
  for (std::size_t i = 0; i < size; ++i)
    numbers[i] = parse(path_of(key.name) + "." + std::to_string(i), list->items[i]).value_or(numbers[i]);
}

std::size_t Keys::size(const std::string& key) {
  const Value* value = raw(key);
  if (value == nullptr) return 0;
  if (value->kind == Value::Kind::sequence) return value->items.size();
  reject(key, "is " + quoted(*value) + " (a list is needed). Start each entry with a dash.");
  return 0;
}

ordered_json Keys::written(const Declare& declare) {
  ordered_json section = ordered_json::object();
  Keys keys(&section, nullptr);
  declare(keys);
  return section;
}

ordered_json Keys::described(const Declare& declare) {
  ordered_json schema{{"type", "object"}, {"additionalProperties", false}, {"properties", ordered_json::object()}};
  Keys keys(nullptr, &schema);
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

/// Writes and describes what may have been read.
/// @param form  makes the schema of the value
void Keys::record(const Key& key, const auto& value, const char* description, const auto& form) {
  write(key.name, value);
  if (describes()) describe(key, with_default(form(), value, key), description);
}

void Keys::number(const Key& key, double& value, Range range, const char* description) {
  if (const Value* given = wanted(key)) value = parse_number(path_of(key.name), *given, range).value_or(value);
  record(key, value, description, [&] { return schema_of_number(range); });
}

void Keys::number(const Key& key, std::optional<double>& value, Range range, const char* description) {
  if (const Value* given = raw(key.name)) value = parse_number(path_of(key.name), *given, range).value_or(0.0);
  if (value) write(key.name, *value);
  if (describes()) describe(key, schema_of_number(range), description);
}

void Keys::number_or(const Key& key, std::optional<double>& value, Range range, const char* word_of_none,
                     const char* word_of_zero, const std::string& number_of, const char* description) {
  const std::string zero = word_of_zero;
  if (reads()) {
    const Value* given = raw(key.name);
    const std::string word = given == nullptr ? word_of_none : given->text;
    value.reset();
    if (!zero.empty() && word == zero) {
      value = 0.0;
    } else if (given != nullptr && word != word_of_none) {
      if (given->kind == Value::Kind::scalar && std::isalpha(static_cast<unsigned char>(word.front())) != 0)
        reject(key.name, "is '" + word + "' (known: " + word_of_none + (zero.empty() ? "" : ", " + zero) +
                             "). Write one of these, or a number of " + number_of + ".");
      else
        value = parse_number(path_of(key.name), *given, range).value_or(0.0);
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
  if (const Value* given = wanted(key)) value = parse_integer(path_of(key.name), *given, range).value_or(value);
  record(key, value, description, [&] { return schema_of_integer(range); });
}

void Keys::numbers(const Key& key, Eigen::Ref<Eigen::VectorXd> values, const char* description) {
  const auto parse = [this](const auto& path, const Value& item) { return parse_number(path, item, Range::any); };
  read_list(key, parse, values);
  const auto size = static_cast<std::size_t>(values.size());
  record(key, values, description, [&] { return schema_of_list(schema_of_number(Range::any), size); });
}

void Keys::integers(const Key& key, std::span<std::int64_t> values, Range range, const char* description) {
  read_list(
      key, [&](const auto& path, const Value& item) { return parse_integer(path, item, range); }, values);
  record(key, values, description, [&] { return schema_of_list(schema_of_integer(range), values.size()); });
}

void Keys::text(const Key& key, std::string& value, const char* description) {
  const Value* given = wanted(key);
  if (given != nullptr && (given->kind != Value::Kind::scalar || given->text.empty()))
    reject(key.name, "is " + quoted(*given) + " (a word is needed). Write one word.");
  else if (given != nullptr)
    value = given->text;
  write(key.name, value);
  describe(key, form_of_text, description);
}

void Keys::name(const Key& key, std::string& value, const char* description) {
  text(key, value, description);
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (std::ranges::any_of(value, is_control))
    reject(key.name, "has control characters (a terminal would obey them). Leave them out.");
  else if (value.find('/') != std::string::npos || value.starts_with("."))
    reject(key.name, "is '" + value + "' (it names files and folders). Leave out slashes and a leading dot.");
}

void Keys::words(const Key& key, std::vector<std::string>& values, std::size_t count, const char* description) {
  if (reads()) values.clear();
  if (const Value* given = raw(key.name)) {
    const std::vector<Value> items = given->kind == Value::Kind::scalar ? std::vector{*given} : given->items;
    for (const Value& item : items)
      if (item.kind == Value::Kind::scalar) values.push_back(item.text);
    reject_if(given->kind == Value::Kind::mapping || values.size() != items.size(), key.name,
              "is not a list of words (each entry must be one word). Write it in brackets: [a, b].");
  }
  write(key.name, values);
  if (describes()) describe(key, schema_of_list(form_of_text, count), description);
}

void Keys::command(const Key& key, std::vector<std::string>& words, const char* description) {
  if (describes()) return describe(key, {{"anyOf", {form_of_text, schema_of_list(form_of_text, 0)}}}, description);
  this->words(key, words, 0, description);
  const Value* given = raw(key.name);
  if (given == nullptr || given->kind != Value::Kind::scalar) return;
  try {
    words = split_command(given->text);
  } catch (const CaseError& error) {
    words.clear();
    problems_->error(path_of(key.name), path_of(key.name) + ": " + error.what());
  }
}

void Keys::flag(const Key& key, bool& value, const char* description) {
  constexpr std::array names{"false", "true"};
  if (describes()) return describe(key, with_default({{"type", "boolean"}}, value, key), description);
  value = choose(key, value ? 1 : 0, names, description) == 1;
}

std::size_t Keys::choose(const Key& key, std::size_t place, std::span<const char* const> names,
                         const char* description) {
  write(key.name, names[place]);
  describe(key, with_default({{"enum", names}}, names[place], key), description);
  const Value* given = wanted(key);
  if (given == nullptr) return place;
  const auto found = std::ranges::find(names, given->text);
  if (given->kind == Value::Kind::scalar && found != names.end())
    return static_cast<std::size_t>(found - names.begin());
  const std::vector<std::string> known(names.begin(), names.end());
  const std::string nearest = nearest_word(given->text, known);
  reject(key.name, "is " + quoted(*given) + " (allowed: " + listed(known) + "). " +
                       (nearest.empty() ? "Choose one of them." : "Did you mean " + nearest + "?"));
  return place;
}

void Keys::section(const Key& key, const char* description, const Declare& declare) {
  if (reads()) {
    Keys below(raw(key.name), path_of(key.name), *problems_);
    declare(below);
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
    if (reads()) {
      Keys below(&raw(key.name)->items[i], path_of(key.name) + "." + std::to_string(i), *problems_);
      declare_item(below);
    }
    if (resolved_ != nullptr) (*resolved_)[key.name].push_back(written(declare_item));
    if (describes() && i == 0) describe(key, schema_of_list(described(declare_item), 0), description);
  }
}

std::vector<std::string> split_command(const std::string& command) {
  std::vector<std::string> words;
  bool inside = false;
  const auto word = [&]() -> std::string& { return std::exchange(inside, true) ? words.back() : words.emplace_back(); };
  char quote = 0;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (c == '\\' && quote != '\'' && i + 1 < command.size()) {
      word() += command[++i];
    } else if (quote != 0 && c == quote) {
      quote = 0;
    } else if (quote == 0 && (c == '"' || c == '\'')) {
      quote = c;
      word();  // perhaps an empty one
    } else if (quote == 0 && (c == ' ' || c == '\t')) {
      inside = false;
    } else {
      word() += c;
    }
  }
  if (quote != 0)
    throw CaseError("'" + command + "' opens a quote that never closes (where does the word end?). Close it.");
  return words;
}

}  // namespace copepod::coupler
