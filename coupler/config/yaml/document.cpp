#include "config/yaml/document.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <regex>
#include <sstream>
#include <utility>

#include "contract/words.hpp"

namespace copepod::coupler {

namespace {

nlohmann::ordered_json number_or_text(const std::string& text) {
  if (text == "true" || text == "false") return text == "true";
  constexpr double countable = 1e15;
  const std::optional<double> number = number_in<double>(text);
  if (!number || !std::isfinite(*number)) return text;
  const bool is_whole = *number == std::floor(*number) && std::abs(*number) < countable;
  return is_whole ? nlohmann::ordered_json(static_cast<std::int64_t>(*number)) : nlohmann::ordered_json(*number);
}

/// Item of a list by its position, or by the `name` it carries.
Value* find_item(Value& list, const std::string& part) {
  if (const auto index = number_in<std::size_t>(part))
    return *index < list.items.size() ? &list.items[*index] : nullptr;
  for (Value& item : list.items) {
    const Value* name = item.find("name");
    if (name != nullptr && name->text == part) return &item;
  }
  return nullptr;
}

/// What warnings of one kind have in common: their text without quoted names, numbers and the place.
std::string kind_of(const std::string& message) {
  static const std::regex particulars("'[^']*'|[0-9][-+.e0-9]*");
  return std::regex_replace(message, particulars, "#");
}

bool at_or_below(const std::string& path, const std::string& top) { return path == top || path.starts_with(top + "."); }

Value::Entry parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  const Origin origin{"--set " + text, 0};
  if (equals == std::string::npos || equals == 0) {
    const std::string what = equals == 0 ? "there is no key before the equals sign" : "an equals sign is missing";
    throw CaseInvalid(origin, "'" + text + "' is not an assignment (" + what + "). Write --set key.path=value.");
  }
  return {text.substr(0, equals), origin, parse_yaml(text.substr(equals + 1), origin)};
}

}  // namespace

std::string to_string(const Origin& origin) {
  return origin.line > 0 ? origin.source + ":" + std::to_string(origin.line) : origin.source;
}

std::string shortest_text(double number) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return {buffer.data(), end};
}

const Value* Value::find(std::string_view key) const {
  for (const Entry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

Value* Value::find(std::string_view key) { return const_cast<Value*>(std::as_const(*this).find(key)); }

nlohmann::ordered_json to_json(const Value& value, Scalars scalars) {
  using nlohmann::ordered_json;
  switch (value.kind) {
    case Value::Kind::null:
      return nullptr;
    case Value::Kind::scalar:
      return scalars == Scalars::as_numbers ? number_or_text(value.text) : ordered_json(value.text);
    case Value::Kind::sequence: {
      ordered_json array = ordered_json::array();
      for (const Value& item : value.items) array.push_back(to_json(item, scalars));
      return array;
    }
    case Value::Kind::mapping:
      break;
  }
  ordered_json object = ordered_json::object();
  for (const Value::Entry& entry : value.entries) object[entry.key] = to_json(entry.value, scalars);
  return object;
}

Document Document::load(const std::string& file, const std::vector<std::string>& overrides) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  if (!stream || !(text << stream.rdbuf())) {
    throw CaseInvalid(Origin{file, 0},
                      "the case file cannot be read (missing, empty, a folder, or no permission). Give the path of a "
                      "YAML case file.");
  }
  return parse(text.str(), file, overrides);
}

Document Document::parse(const std::string& text, const std::string& source,
                         const std::vector<std::string>& overrides) {
  const Origin start{source, 1};
  Value written = parse_yaml(text, start);
  if (written.kind != Value::Kind::mapping) {
    throw CaseInvalid(start,
                      "the case is not a mapping (it must consist of `key: value` lines). Start it with `case: name`.");
  }
  std::vector<Value::Entry> assignments;
  assignments.reserve(overrides.size());
  for (const std::string& override_text : overrides) assignments.push_back(parse_override(override_text));
  return {std::move(written), std::move(assignments)};
}

Document Document::with(const std::vector<Value::Entry>& assignments) const {
  std::vector<Value::Entry> all = assignments_;
  all.insert(all.end(), assignments.begin(), assignments.end());
  return {written_, std::move(all)};
}

Document::Document(Value written, std::vector<Value::Entry> assignments)
    : written_(std::move(written)), assignments_(std::move(assignments)), root_(written_) {
  bool set_chosen = false;
  for (const Value::Entry& assignment : assignments_) {
    if (assignment.key != "parameter_set") continue;
    assign(assignment.key, assignment.value);
    set_chosen = true;
  }
  apply_parameter_set(set_chosen);
  for (const Value::Entry& assignment : assignments_) assign(assignment.key, assignment.value);
}

void Document::apply_parameter_set(bool chosen_by_assignment) {
  const Value* chosen = root_.find("parameter_set");
  const Value* sets = root_.find("parameter_sets");
  if (chosen == nullptr || sets == nullptr) {
    if (chosen_by_assignment) {
      throw CaseInvalid(chosen->origin,
                        "parameter_set '" + chosen->text +
                            "' chooses nothing (the case has no parameter_sets). Leave the option out.");
    }
    return;
  }
  const Value* set = sets->find(chosen->text);
  if (set == nullptr || set->kind != Value::Kind::mapping) {
    std::vector<std::string> known;
    for (const Value::Entry& entry : sets->entries) known.push_back(entry.key);
    throw CaseInvalid(chosen->origin, "parameter_set '" + chosen->text +
                                          "' does not exist (parameter_sets has no such mapping). Choose one of: " +
                                          listed(known) + ".");
  }
  const std::vector<Value::Entry> assignments = set->entries;  // a copy: assign() changes the tree that holds it
  for (const Value::Entry& entry : assignments) assign(entry.key, entry.value);
}

void Document::assign(const std::string& path, Value value) {
  Value* node = &root_;
  std::stringstream parts(path);
  for (std::string part; std::getline(parts, part, '.');) {
    Value* child = node->kind == Value::Kind::sequence ? find_item(*node, part) : node->find(part);
    if (node->kind == Value::Kind::sequence && std::ranges::any_of(node->items, [&](const Value& item) {
          const Value* name = item.find("name");
          return &item != child && name != nullptr && name->text == part;
        }))
      throw CaseInvalid(value.origin, "'" + path + "' is ambiguous ('" + part +
                                          "' is the position of one item and the name of another). Rename that one.");
    if (child == nullptr) {
      if (node->kind == Value::Kind::null) node->kind = Value::Kind::mapping;
      if (node->kind != Value::Kind::mapping) {
        throw CaseInvalid(value.origin, "'" + path + "' leads nowhere ('" + part +
                                            "' is not part of the list or value before it). Use a position counted "
                                            "from 0, or the name of an item.");
      }
      node->entries.push_back({part, value.origin, {Value::Kind::mapping, {}, {}, {}, value.origin}});
      child = &node->entries.back().value;
    }
    node = child;
  }
  *node = std::move(value);
}

Origin Document::locate(const std::string& path) const {
  const Value* node = &root_;
  Origin found = root_.origin;
  std::string rest = path;
  while (!rest.empty()) {
    std::size_t length = rest.find('.');
    if (node->kind == Value::Kind::mapping) {
      const Value::Entry* match = nullptr;
      for (const Value::Entry& entry : node->entries) {  // a key may itself be a path: the longest counts
        if (at_or_below(rest, entry.key) && (match == nullptr || entry.key.size() > match->key.size())) match = &entry;
      }
      if (match == nullptr) break;
      // A section starts where its key stands, a scalar where it is written.
      found = match->value.kind == Value::Kind::scalar ? match->value.origin : match->key_origin;
      node = &match->value;
      length = match->key.size();
    } else {
      const Value* item = find_item(const_cast<Value&>(*node), rest.substr(0, length));
      if (item == nullptr) break;
      found = item->origin;
      node = item;
    }
    rest = length < rest.size() ? rest.substr(length + 1) : "";
  }
  return found;
}

CaseInvalid::CaseInvalid(std::vector<std::string> lines) : CaseError(listed(lines, "\n")), lines_(std::move(lines)) {}

CaseInvalid::CaseInvalid(const Origin& origin, const std::string& message)
    : CaseInvalid(std::vector<std::string>{to_string(origin) + ": error: " + message}) {}

void Problems::error(const std::string& path, const std::string& message) {
  if (at_or_below(path, "swarm.template") && !kinds_of_template_.insert(path + kind_of(message)).second) return;
  error_at(document_.locate(path), path, message);
}

void Problems::warning(const std::string& path, const std::string& message) {
  const auto [kind, is_new] = kinds_.emplace(kind_of(message), warnings_.size());
  if (is_new)
    warnings_.push_back({to_string(document_.locate(path)) + ": warning: " + message, 0});
  else
    ++warnings_[kind->second].others;
}

std::vector<std::string> Problems::warnings() const {
  std::vector<std::string> lines;
  for (const Warning& warning : warnings_)
    lines.push_back(warning.line +
                    (warning.others == 0 ? "" : " (" + std::to_string(warning.others) + " more of this kind.)"));
  return lines;
}

bool Problems::any_under(const std::string& path) const {
  return std::any_of(errors_.begin(), errors_.end(), [&](const Entry& e) { return at_or_below(e.path, path); });
}

void Problems::throw_if_any() const {
  if (errors_.empty()) return;
  std::vector<Entry> sorted = errors_;
  std::ranges::stable_sort(sorted, {}, [](const Entry& entry) { return entry.origin.line; });
  std::vector<std::string> lines;
  for (const Entry& entry : sorted) {
    if (lines.empty() || lines.back() != entry.line) lines.push_back(entry.line);
  }
  throw CaseInvalid(std::move(lines));
}

}  // namespace copepod::coupler
