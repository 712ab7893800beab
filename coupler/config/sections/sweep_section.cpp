#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <set>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/fmt.h>

#include "config/sections/sections.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t most_members = 10'000;

/// A value rounded to a thousandth of `distance`, in the shortest text.
std::string neat_text(double value, double distance) {
  constexpr int most_digits = 15;
  if (value == 0.0) return "0";
  const auto exponent = [](double number) { return static_cast<int>(std::floor(std::log10(std::abs(number)))); };
  const int digits = std::min(exponent(value) - exponent(distance) + 4, most_digits);
  if (digits < 1) return "0";  // the rounding error of a sum that vanishes
  const double rounded = std::strtod(fmt::format("{:.{}e}", value, digits - 1).c_str(), nullptr);
  const bool is_whole = rounded == std::floor(rounded) && std::abs(rounded) < 1e15;
  return is_whole ? std::to_string(static_cast<long long>(rounded)) : shortest_text(rounded);
}

/// A range of values as it is written.
struct SweptRange {
  double from = 0.0;
  double to = 0.0;
  std::int64_t count = 0;
  SweepScale scale = SweepScale::linear;
};

void declare(Keys& keys, SweptRange& range) {
  keys.number(required("from"), range.from, Range::any, "First value.");
  keys.number(required("to"), range.to, Range::any, "Last value.");
  keys.integer(required("count"), range.count, Range::positive, "Number of values, both ends included.");
  keys.describe_also("count", {{"minimum", 2}, {"maximum", most_members}});
  keys.choice("scale", range.scale, scale_names,
              "Constant differences (linear) or constant ratios (logarithmic) between values; plots follow.");
}

void read_range(Keys range, SweptKey& parameter, const Origin& origin) {
  SweptRange written;
  declare(range, written);
  const auto& [from, to, count, scale] = written;
  parameter.scale = scale;
  for (const char* key : {"from", "to", "count", "scale"})
    if (range.has_errors(key)) return;
  if (count < 2 || count > static_cast<std::int64_t>(most_members)) {
    range.reject("count", "is " + std::to_string(count) + " (a range has 2 to " + std::to_string(most_members) +
                              " values, ends included). Write a list for a single value.");
  } else if (from == to) {
    range.reject("to", "is " + shortest_text(to) + " (so is `from`). Give the other end of the range.");
  } else if (parameter.scale == SweepScale::logarithmic && from / to <= 0.0) {
    range.reject("scale", "is logarithmic (the range from " + shortest_text(from) + " to " + shortest_text(to) +
                              " holds zero). Choose ends of one sign, or scale: linear.");
  } else {
    for (const std::string& text : range_texts(from, to, count, parameter.scale))
      parameter.values.push_back({Value::Kind::scalar, text, {}, {}, origin});
  }
}

SweptKey read_parameter(Keys& section, const Value::Entry& entry) {
  SweptKey parameter{entry.key, SweepScale::linear, {}};
  const std::string key = "parameters." + entry.key;
  if (entry.value.kind == Value::Kind::mapping) {
    read_range(Keys(&entry.value, section.path_of(key), section.problems()), parameter, entry.key_origin);
  } else if (entry.value.kind != Value::Kind::sequence) {
    section.reject(key,
                   "is not a list (a swept key takes several values). Write [1, 2, 3] or {from: 1, to: 3, count: 3}.");
  } else if (entry.value.items.empty()) {
    section.reject(key, "has no values (there is nothing to run). List them: [1.0e-6, 2.0e-6].");
  } else {
    parameter.values = entry.value.items;
  }
  return parameter;
}

void check_lengths(const Sweep& sweep, Keys& section) {
  const SweptKey& first = sweep.parameters.front();
  for (const SweptKey& other : sweep.parameters) {
    if (other.values.size() == first.values.size()) continue;
    return section.reject("combine", "is zip, but " + first.key + " has " + std::to_string(first.values.size()) +
                                         " values and " + other.key + " has " + std::to_string(other.values.size()) +
                                         " (each run takes one of both). Give both as many, or write combine: grid.");
  }
}

void check_number_of_members(const Sweep& sweep, Keys& section) {
  double members = 1.0;
  std::vector<std::string> factors;
  for (const SweptKey& parameter : sweep.parameters) {
    members *= static_cast<double>(parameter.values.size());
    factors.push_back(std::to_string(parameter.values.size()));
  }
  if (sweep.combination == SweepCombination::zip || members <= static_cast<double>(most_members)) return;
  section.reject("parameters", fmt::format("have {:.6g} combinations ({}; at most {} are run). Give fewer values, or "
                                           "combine: zip.",
                                           members, listed(factors, " × "), most_members));
}

void check_twins(const Sweep& sweep, Keys& section) {
  std::set<std::string> known;
  for (std::size_t member = 0; member < member_count(sweep); ++member) {
    if (known.insert(member_text(sweep, member)).second) continue;
    return section.reject("parameters", "have " + member_text(sweep, member) +
                                            " twice (the same run would be made again). Leave one of them out.");
  }
}

/// The form of older versions.
void refuse_single_key(const Document& document, const Value& sweep) {
  if (sweep.find("key") == nullptr && sweep.find("values") == nullptr) return;
  throw CaseInvalid(document.locate("sweep"),
                    "sweep.key and sweep.values have become sweep.parameters (it takes several keys). Write sweep: "
                    "{parameters: {key.path: [1, 2, 3]}}.");
}

ordered_json schema_of_parameters() {
  SweptRange any;
  const ordered_json range = Keys::described([&](Keys& keys) { declare(keys, any); });
  const ordered_json list{{"type", "array"}, {"minItems", 1}};
  return {{"type", "object"}, {"minProperties", 1}, {"additionalProperties", {{"anyOf", {list, range}}}}};
}

void declare(Keys& keys, Sweep& sweep) {
  keys.describe(required("parameters"), schema_of_parameters(),
                "Key paths, as with --set, each with a list of values or a range.");
  keys.choice(
      "combine", sweep.combination, combination_names,
      "grid: every combination of the values; zip: the first values of all keys, then the second ones, and so on.");
  if (const Value* parameters = keys.mapping("parameters"))
    for (const Value::Entry& entry : parameters->entries) sweep.parameters.push_back(read_parameter(keys, entry));
}

Sweep read_section(Keys section) {
  Sweep sweep;
  declare(section, sweep);
  if (section.problems().any()) return sweep;
  if (sweep.parameters.empty()) {
    section.reject("parameters",
                   "is empty (a sweep varies one key at least). Write parameters: {key.path: [1.0e-6, 2.0e-6]}.");
    return sweep;
  }
  if (sweep.combination == SweepCombination::zip) check_lengths(sweep, section);
  check_number_of_members(sweep, section);
  if (!section.problems().any()) check_twins(sweep, section);
  return sweep;
}

/// Last part of a key path; all of it where another swept key ends alike.
std::string short_key(const Sweep& sweep, const std::string& key) {
  const auto last = [](const std::string& path) { return path.substr(path.rfind('.') + 1); };
  const auto alike =
      std::ranges::count_if(sweep.parameters, [&](const SweptKey& other) { return last(other.key) == last(key); });
  const bool is_position = last(key).find_first_not_of("0123456789") == std::string::npos;
  return alike > 1 || is_position ? key : last(key);
}

}  // namespace

std::size_t member_count(const Sweep& sweep) {
  if (sweep.combination == SweepCombination::zip) return sweep.parameters.front().values.size();
  std::size_t count = 1;
  for (const SweptKey& parameter : sweep.parameters) count *= parameter.values.size();
  return count;
}

std::vector<Value::Entry> assignments_of(const Sweep& sweep, std::size_t member) {
  std::vector<Value::Entry> assignments{{"sweep", {}, {}}};
  for (auto parameter = sweep.parameters.rbegin(); parameter != sweep.parameters.rend(); ++parameter) {
    const std::size_t count = parameter->values.size();
    const Value& value = parameter->values[member % count];
    assignments.push_back({parameter->key, value.origin, value});
    if (sweep.combination == SweepCombination::grid) member /= count;
  }
  std::ranges::reverse(assignments);
  return assignments;
}

std::string member_text(const Sweep& sweep, std::size_t member) {
  std::string text;
  std::vector<Value::Entry> assignments = assignments_of(sweep, member);
  assignments.pop_back();
  for (const Value::Entry& assignment : assignments) {
    text += (text.empty() ? "" : ", ") + short_key(sweep, assignment.key) + "=" +
            to_json(assignment.value, Scalars::as_numbers).dump();
  }
  return text;
}

std::string setting_text(const Value::Entry& assignment) {
  const bool is_number = to_json(assignment.value, Scalars::as_numbers).is_number();
  return assignment.key + "=" + (is_number ? assignment.value.text : to_json(assignment.value).dump());
}

std::vector<std::string> range_texts(double from, double to, std::size_t count, SweepScale scale) {
  std::vector<std::string> texts;
  const auto last = static_cast<double>(count - 1);
  const auto value_at = [&](double i) {
    return scale == SweepScale::linear ? (from * (last - i) + to * i) / last : from * std::pow(to / from, i / last);
  };
  for (std::size_t place = 0; place < count; ++place) {
    const auto i = static_cast<double>(place);
    const bool is_end = place == 0 || place + 1 == count;  // as it was written
    const double distance = is_end ? value_at(i) * 1e-12 : value_at(i) - value_at(i - 1.0);
    texts.push_back(neat_text(value_at(i), distance));
  }
  return texts;
}

void describe_sweep(Keys& keys) {
  Sweep any;
  keys.section("sweep", "Runs the case with several values of some keys, a few runs at a time.",
               [&](Keys& sweep) { declare(sweep, any); });
}

std::optional<Sweep> read_sweep(const Document& document) {
  const Value* value = document.root().find("sweep");
  if (value == nullptr || value->kind == Value::Kind::null) return {};
  refuse_single_key(document, *value);
  Problems problems(document);
  Sweep sweep = read_section(Keys(value, "sweep", problems));
  problems.throw_if_any();
  return sweep;
}

}  // namespace copepod::coupler
