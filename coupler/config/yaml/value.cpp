#include "config/yaml/value.hpp"

#include <array>
#include <charconv>
#include <utility>

namespace copepod::coupler {

std::string to_string(const Origin& origin) {
  return origin.line > 0 ? origin.source + ":" + std::to_string(origin.line) : origin.source;
}

std::string shortest_text(double number) {
  std::array<char, 32> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), number).ptr;
  return {buffer.data(), end};
}

Value Value::mapping() {
  Value value;
  value.kind = Kind::mapping;
  return value;
}

void Value::add(const std::string& key, Value item) {
  Origin where = item.origin;
  entries.push_back({key, std::move(where), std::move(item)});
}

const Value* Value::find(std::string_view key) const {
  for (const Entry& entry : entries) {
    if (entry.key == key) return &entry.value;
  }
  return nullptr;
}

Value* Value::find(std::string_view key) { return const_cast<Value*>(std::as_const(*this).find(key)); }

nlohmann::ordered_json to_json(const Value& value) {
  using nlohmann::ordered_json;
  switch (value.kind) {
    case Value::Kind::null:
      return nullptr;
    case Value::Kind::scalar:
      return value.text;
    case Value::Kind::sequence: {
      ordered_json array = ordered_json::array();
      for (const Value& item : value.items) array.push_back(to_json(item));
      return array;
    }
    case Value::Kind::mapping:
      break;
  }
  ordered_json object = ordered_json::object();
  for (const Value::Entry& entry : value.entries) object[entry.key] = to_json(entry.value);
  return object;
}

}  // namespace copepod::coupler
