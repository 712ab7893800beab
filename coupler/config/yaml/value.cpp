#include "config/yaml/value.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <utility>

namespace copepod::coupler {
namespace {

nlohmann::ordered_json number_or_text(const std::string& text) {
  constexpr double countable = 1e15;
  double number = 0.0;
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, number);
  if (error != std::errc{} || stop != end || !std::isfinite(number)) return text;
  const bool is_whole = number == std::floor(number) && std::abs(number) < countable;
  return is_whole ? nlohmann::ordered_json(static_cast<std::int64_t>(number)) : nlohmann::ordered_json(number);
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

}  // namespace copepod::coupler
