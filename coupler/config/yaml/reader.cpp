#include "config/yaml/reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

std::string quoted(const Value& value) {
  const std::array<std::string, 4> kinds{"nothing", "'" + value.text + "'", "a list", "a section"};
  return kinds[static_cast<std::size_t>(value.kind)];
}

}  // namespace

Reader::Reader(const Value* mapping, std::string path, Problems& problems)
    : mapping_(mapping), path_(std::move(path)), problems_(problems) {
  if (mapping_ == nullptr || mapping_->kind == Value::Kind::mapping) return;
  if (mapping_->kind != Value::Kind::null) {
    problems_.reject(path_, "is " + quoted(*mapping_) + " (a section is needed). Write `key: value` lines below it.");
  }
  mapping_ = nullptr;
}

Reader::~Reader() {
  if (mapping_ == nullptr || accepts_all_) return;
  const std::vector<std::string> known(known_.begin(), known_.end());
  for (const Value::Entry& entry : mapping_->entries) {
    if (known_.contains(entry.key)) continue;
    const std::string where = path_.empty() ? "at the top of the case" : "in " + path_;
    problems_.error_at(entry.key_origin, path_of(entry.key),
                       "key '" + entry.key + "' is unknown (nothing " + where + " has this name). " +
                           hint_for(entry.key, known, problems_.all_keys()));
  }
}

const Value* Reader::raw(const std::string& key) {
  known_.insert(key);
  const Value* value = mapping_ == nullptr ? nullptr : mapping_->find(key);
  return value == nullptr || value->kind == Value::Kind::null ? nullptr : value;
}

const Value* Reader::wanted(const std::string& key, bool required) {
  const Value* value = raw(key);
  if (value == nullptr && required) {
    reject(key, "is missing (the case cannot run without it). Add `" + key + ": …`.");
  }
  return value;
}

std::optional<double> Reader::parse_number(const std::string& path, const Value& value, Range range) {
  const std::string_view text = value.text;
  const std::optional<double> number = number_in<double>(text.substr(text.starts_with('+') ? 1 : 0));
  if (value.kind != Value::Kind::scalar || !number || !std::isfinite(*number)) {
    problems_.reject(path, "is " + quoted(value) + " (a finite number is needed). Write it like 1.0e-6.");
    return {};
  }
  if ((range == Range::positive && *number <= 0) || (range == Range::not_negative && *number < 0)) {
    problems_.reject(path, "is " + value.text + " (it must " +
                               (range == Range::positive ? "be positive" : "not be negative") +
                               "). Check sign and value.");
    return {};
  }
  return number;
}

std::optional<std::int64_t> Reader::parse_integer(const std::string& path, const Value& value, Range range) {
  const std::optional<std::int64_t> number = number_in<std::int64_t>(value.text);
  if (value.kind != Value::Kind::scalar || !number) {
    problems_.reject(path, "is " + quoted(value) + " (a whole number is needed). Write it like 1000.");
    return {};
  }
  constexpr std::int64_t largest = 1'000'000'000'000'000;  // sums and differences of two stay countable
  if (*number > largest || *number < -largest) {
    problems_.reject(path, "is " + value.text + " (values in a case do not exceed 10^15). Check its digits.");
    return {};
  }
  return parse_number(path, value, range) ? number : std::nullopt;
}

double Reader::number(const std::string& key, Range range, std::optional<double> otherwise) {
  const Value* value = wanted(key, !otherwise);
  const auto number = value == nullptr ? std::nullopt : parse_number(path_of(key), *value, range);
  return number ? *number : otherwise.value_or(0.0);
}

std::int64_t Reader::integer(const std::string& key, Range range, std::optional<std::int64_t> otherwise) {
  const Value* value = wanted(key, !otherwise);
  const auto number = value == nullptr ? std::nullopt : parse_integer(path_of(key), *value, range);
  return number ? *number : otherwise.value_or(0);
}

std::string Reader::text(const std::string& key, const std::optional<std::string>& otherwise) {
  const Value* value = wanted(key, !otherwise);
  if (value == nullptr) return otherwise.value_or("");
  if (value->kind != Value::Kind::scalar || value->text.empty()) {
    reject(key, "is " + quoted(*value) + " (a word is needed). Write one word.");
    return otherwise.value_or("");
  }
  return value->text;
}

std::string Reader::name(const std::string& key, const std::optional<std::string>& otherwise) {
  const std::string name = text(key, otherwise);
  const auto is_control = [](unsigned char c) { return c < 0x20 || c == 0x7f; };
  if (std::any_of(name.begin(), name.end(), is_control)) {
    reject(key, "has control characters (a terminal would obey them). Leave them out.");
  } else if (name.find('/') != std::string::npos || name.starts_with(".")) {
    reject(key, "is '" + name + "' (it names files and folders). Leave out slashes and a leading dot.");
  }
  return name;
}

const Value* Reader::wanted_list(const std::string& key, std::size_t size, bool required) {
  const Value* value = wanted(key, required);
  if (value == nullptr) return nullptr;
  if (value->kind == Value::Kind::sequence && value->items.size() == size) return value;
  const std::string found = value->kind == Value::Kind::sequence
                                ? "has " + std::to_string(value->items.size()) + " entries"
                                : "is " + quoted(*value);
  reject(key, found + " (a list of " + std::to_string(size) + " is needed). Write it in brackets: [a, b, …].");
  return nullptr;
}

/// @param parse  what is parsed of an item; what cannot be used keeps its value in `numbers`
void Reader::read_list(const std::string& key, bool required, const auto& parse, auto& numbers) {
  const Value* list = wanted_list(key, static_cast<std::size_t>(numbers.size()), required);
  for (std::size_t i = 0; list != nullptr && i < list->items.size(); ++i)
    if (const auto number = parse(path_of(key) + "." + std::to_string(i), list->items[i])) numbers[i] = *number;
}

Eigen::VectorXd Reader::numbers(const std::string& key, Eigen::Index size,
                                const std::optional<Eigen::VectorXd>& otherwise) {
  Eigen::VectorXd result = otherwise.value_or(Eigen::VectorXd::Zero(size));
  const auto parse = [this](const auto& path, const Value& item) { return parse_number(path, item, Range::any); };
  read_list(key, !otherwise, parse, result);
  return result;
}

std::vector<std::int64_t> Reader::integers(const std::string& key, std::size_t size, Range range,
                                           const std::optional<std::vector<std::int64_t>>& otherwise) {
  std::vector<std::int64_t> result = otherwise.value_or(std::vector<std::int64_t>(size, 1));
  const auto parse = [&](const auto& path, const Value& item) { return parse_integer(path, item, range); };
  read_list(key, !otherwise, parse, result);
  return result;
}

std::vector<std::string> Reader::words(const std::string& key) {
  const Value* value = raw(key);
  std::vector<std::string> result;
  if (value == nullptr) return result;
  if (value->kind == Value::Kind::scalar) return {value->text};
  for (const Value& item : value->items) {
    if (item.kind == Value::Kind::scalar) result.push_back(item.text);
  }
  if (value->kind != Value::Kind::sequence || result.size() != value->items.size()) {
    reject(key, "is not a list of words (each entry must be one word). Write it in brackets: [a, b].");
  }
  return result;
}

std::vector<std::string> Reader::command(const std::string& key) {
  const Value* value = raw(key);
  if (value == nullptr || value->kind != Value::Kind::scalar) return words(key);
  try {
    return split_command(value->text);
  } catch (const CaseError& error) {
    problems_.error(path_of(key), path_of(key) + ": " + error.what());
    return {};
  }
}

std::size_t Reader::choose(const std::string& key, const std::vector<std::string>& names, bool required) {
  const Value* value = wanted(key, required);
  if (value == nullptr) return names.size();
  const auto found = std::find(names.begin(), names.end(), value->text);
  if (value->kind == Value::Kind::scalar && found != names.end()) {
    return static_cast<std::size_t>(found - names.begin());
  }
  const std::string nearest = nearest_word(value->text, names);
  reject(key, "is " + quoted(*value) + " (allowed: " + listed(names) + "). " +
                  (nearest.empty() ? "Choose one of them." : "Did you mean " + nearest + "?"));
  return names.size();
}

std::size_t Reader::size(const std::string& key) {
  const Value* value = raw(key);
  if (value == nullptr) return 0;
  if (value->kind == Value::Kind::sequence) return value->items.size();
  reject(key, "is " + quoted(*value) + " (a list is needed). Start each entry with a dash.");
  return 0;
}

std::vector<std::string> split_command(const std::string& command) {
  std::vector<std::string> words;
  std::string word;
  bool inside = false;
  char quote = 0;
  for (std::size_t i = 0; i < command.size(); ++i) {
    const char c = command[i];
    if (c == '\\' && quote != '\'' && i + 1 < command.size()) {
      word += command[++i];
      inside = true;
    } else if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '"' || c == '\'') {
      quote = c;
      inside = true;
    } else if (c == ' ' || c == '\t') {
      if (inside) words.push_back(word);
      word.clear();
      inside = false;
    } else {
      word += c;
      inside = true;
    }
  }
  if (quote != 0)
    throw CaseError("'" + command + "' opens a quote that never closes (where does the word end?). Close it.");
  if (inside) words.push_back(word);
  return words;
}

}  // namespace copepod::coupler
