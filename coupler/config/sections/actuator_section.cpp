#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/yaml/csv_rows.hpp"
#include "contract/number_text.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// The keys of a list that are given; reports more than one.
std::vector<std::string> given(Reader& reader, const std::vector<std::string>& keys) {
  std::vector<std::string> found;
  for (const std::string& key : keys) {
    if (reader.has(key)) found.push_back(key);
  }
  if (found.size() > 1)
    reader.reject(found[1], "is given together with " + found[0] + " (both set the same). Remove one.");
  return found;
}

/// A period is a whole number of steps, so that averages over a cycle are over whole cycles.
std::int64_t read_period(Reader& signal, double step_s) {
  const std::vector<std::string> keys = given(signal, {"period_steps", "period_s"});
  if (keys.empty()) return 0;
  if (keys[0] == "period_steps") return signal.integer("period_steps", Range::positive, 1);
  const double steps = signal.number("period_s", Range::positive, step_s) / step_s;
  constexpr double most_steps = 1e15;
  if (!(steps >= 1.0 && steps < most_steps)) {
    if (step_s > 0.0)  // a step that cannot be used is reported elsewhere
      signal.reject("period_s", "is " + rounded_text(steps) +
                                    " steps (at least one, and a number that can be counted). Use another period.");
    return 1;
  }
  if (std::abs(steps - std::round(steps)) > 1e-6 * steps) {
    signal.problems().warning(signal.path_of("period_s"),
                              signal.path_of("period_s") + " is " + rounded_text(steps) +
                                  " steps (a period is a whole number of steps). It is rounded to the nearest.");
  }
  return std::llround(steps);
}

/// Lag in steps.
///   φ = lag_s/Δt,   φ = T lag_rad/2π,   φ = T lag_deg/360
double read_lag(Reader& signal, const Signal& result, double step_s) {
  const std::vector<std::string> keys = given(signal, {"lag_steps", "lag_s", "lag_rad", "lag_deg"});
  if (keys.empty()) return 0.0;
  const double lag = signal.number(keys[0], Range::any, 0.0);
  if (keys[0] == "lag_steps") return lag;
  if (keys[0] == "lag_s") return step_s > 0.0 ? lag / step_s : 0.0;
  if (result.period_steps == 0) signal.reject(keys[0], "is an angle (the signal has no period). Use lag_s.");
  const double turns = keys[0] == "lag_deg" ? lag / 360.0 : lag / (2.0 * std::numbers::pi);
  return turns * static_cast<double>(result.period_steps);
}

/// Rows "time_s,value" of a CSV file, beside the file that names it; the first row may be a header.
std::vector<Signal::Point> read_table_file(Reader& signal, double step_s) {
  const std::optional<CsvRows> rows = read_csv_rows(signal, "file", {"time_s", "value"}, {}, CsvHeader::optional);
  std::vector<Signal::Point> table;
  for (std::size_t row = 0; rows && row < rows->values.size(); ++row) {
    const double time_steps = rows->values[row][0] / step_s;
    if (!table.empty() && !(time_steps > table.back().time_steps)) {
      signal.problems().error_at({rows->path.string(), rows->lines[row]}, signal.path_of("file"),
                                 "time " + rounded_text(rows->values[row][0]) +
                                     " s does not follow that of the row before (times must increase). "
                                     "Sort the rows.");
      return {};
    }
    table.push_back({time_steps, rows->values[row][1]});
  }
  return table;
}

/// The form of the resolved case: a run does not depend on the file.
std::vector<Signal::Point> read_table_lists(Reader& signal) {
  const std::size_t rows = signal.size("times_steps");
  if (rows == 0 || rows != signal.size("values")) {
    signal.reject("times_steps", "and values have " + std::to_string(rows) + " and " +
                                     std::to_string(signal.size("values")) +
                                     " entries (a table pairs them). Give as many of both, or a file.");
    return {};
  }
  const Eigen::VectorXd times = signal.numbers("times_steps", static_cast<Eigen::Index>(rows));
  const Eigen::VectorXd values = signal.numbers("values", static_cast<Eigen::Index>(rows));
  std::vector<Signal::Point> table;
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    if (row > 0 && !(times[row] > times[row - 1])) {
      signal.reject("times_steps", "contains " + rounded_text(times[row]) + " after " + rounded_text(times[row - 1]) +
                                       " (times must increase). Sort the rows.");
      return {};
    }
    table.push_back({times[row], values[row]});
  }
  return table;
}

void read_table(Reader& signal, double step_s, Signal& result) {
  const bool file = signal.has("file");
  const bool values = signal.has("values");
  if (given(signal, {"file", "times_steps"}).size() > 1 && values) return;
  if (file && !(step_s > 0.0)) return;  // a step that cannot be used is reported elsewhere
  result.table = file ? read_table_file(signal, step_s) : read_table_lists(signal);
  if (result.table.empty() || result.period_steps == 0) return;
  const double length_steps = result.table.back().time_steps - result.table.front().time_steps;
  if (length_steps < static_cast<double>(result.period_steps)) return;
  signal.reject(file ? "file" : "times_steps",
                "covers " + rounded_text(length_steps) + " steps, the period has " +
                    std::to_string(result.period_steps) +
                    " (a table that repeats ends before it starts again). Remove rows, or use a longer period.");
}

const char* amplitude_key(ActuatorKind kind, bool rest_length) {
  if (rest_length) return "amplitude_m";
  if (kind == ActuatorKind::control) return factor_key;
  return kind == ActuatorKind::body_torque || kind == ActuatorKind::world_torque ? "amplitude_N_m" : "amplitude_N";
}

/// Words of `kind`: those of the contract, and the rest length, which the coupler turns into a pair force.
struct DriveWord {
  ActuatorKind kind = ActuatorKind::pair_force;
  bool rest_length = false;
  bool operator==(const DriveWord&) const = default;
};

constexpr std::array drive_words{Choice<DriveWord>{"pair_force", {ActuatorKind::pair_force}},
                                 Choice<DriveWord>{"rest_length", {ActuatorKind::pair_force, true}},
                                 Choice<DriveWord>{"body_force", {ActuatorKind::body_force}},
                                 Choice<DriveWord>{"body_torque", {ActuatorKind::body_torque}},
                                 Choice<DriveWord>{"world_force", {ActuatorKind::world_force}},
                                 Choice<DriveWord>{"world_torque", {ActuatorKind::world_torque}},
                                 Choice<DriveWord>{"control", {ActuatorKind::control}}};

constexpr std::array arm_words{Choice<DriveKind>{"pair_force", DriveKind::pair_force},
                               Choice<DriveKind>{"rest_length", DriveKind::rest_length}};

constexpr std::array signal_names{
    Choice<SignalKind>{"constant", SignalKind::constant}, Choice<SignalKind>{"sinusoid", SignalKind::sinusoid},
    Choice<SignalKind>{"square", SignalKind::square}, Choice<SignalKind>{"trapezoid", SignalKind::trapezoid},
    Choice<SignalKind>{"table", SignalKind::table}};

}  // namespace

Signal read_signal(Reader signal, double step_s, const std::string& amplitude) {
  Signal result;
  const auto kind = signal.kind(signal_names);
  if (!kind) return result;
  result.kind = *kind;
  const bool table = result.kind == SignalKind::table;
  const bool periodic = !table && result.kind != SignalKind::constant;
  const bool factor = table || amplitude == factor_key;
  result.amplitude = signal.number(amplitude, Range::any, factor ? std::optional(1.0) : std::nullopt);
  result.period_steps = read_period(signal, step_s);
  if (periodic && result.period_steps == 0) {
    signal.reject("period_steps", "is missing (the signal repeats). Give period_steps or period_s.");
  } else if (result.kind == SignalKind::constant && result.period_steps > 0) {
    signal.reject(signal.has("period_s") ? "period_s" : "period_steps",
                  "is given for a constant (it has no period). Remove it, or use kind: sinusoid.");
  }
  result.lag_steps = read_lag(signal, result, step_s);
  if (signal.has("rise_fraction") || result.kind == SignalKind::trapezoid) {
    result.rise = signal.number("rise_fraction", Range::positive, 0.125);
    if (result.rise > 0.25 || result.kind != SignalKind::trapezoid)
      signal.reject("rise_fraction",
                    "must be at most 0.25, of a trapezoid (the time from 0 to the amplitude, in "
                    "periods). Use a value such as 0.125.");
  }
  if (table) read_table(signal, step_s, result);
  result.ramp_steps = signal.integer("ramp_steps", Range::not_negative, 0);
  result.start_step = signal.integer("start_step", Range::not_negative, 0);
  const Value* stop = signal.raw("stop_step");
  if (stop != nullptr && stop->text != "never") result.stop_step = signal.integer("stop_step", Range::not_negative);
  if (result.stop_step <= result.start_step) {
    signal.reject("stop_step", "is " + std::to_string(result.stop_step) + ", the signal starts at " +
                                   std::to_string(result.start_step) +
                                   " (it would never act). Stop later, or leave it out.");
  }
  return result;
}

ordered_json resolved_signal(const Signal& signal, const char* amplitude) {
  ordered_json section{{"kind", name_of(signal_names, signal.kind)}, {amplitude, signal.amplitude}};
  if (signal.period_steps > 0) section["period_steps"] = signal.period_steps;
  section["lag_steps"] = signal.lag_steps;
  if (signal.kind == SignalKind::trapezoid) section["rise_fraction"] = signal.rise;
  for (const Signal::Point& point : signal.table) {
    section["times_steps"].push_back(point.time_steps);
    section["values"].push_back(point.value);
  }
  section["ramp_steps"] = signal.ramp_steps;
  section["start_step"] = signal.start_step;
  section["stop_step"] = signal.stop_step == Signal::never ? ordered_json("never") : ordered_json(signal.stop_step);
  return section;
}

Drive read_drive(Reader drive, double step_s) {
  Drive result;
  const auto kind = drive.kind(arm_words);
  if (!kind) return result;
  result.kind = *kind;
  const bool rest_length = result.kind == DriveKind::rest_length;
  result.signal = read_signal(drive.section("signal"), step_s, amplitude_key(ActuatorKind::pair_force, rest_length));
  return result;
}

ordered_json resolved_drive(const Drive& drive) {
  const char* amplitude = amplitude_key(ActuatorKind::pair_force, drive.kind == DriveKind::rest_length);
  return {{"kind", name_of(arm_words, drive.kind)}, {"signal", resolved_signal(drive.signal, amplitude)}};
}

NamedActuator read_actuator(Reader actuator, double step_s) {
  NamedActuator result;
  result.bodies.resize(1);
  const auto word = actuator.kind(drive_words);
  if (!word) return result;
  result.kind = word->kind;
  result.rest_length = word->rest_length;
  if (result.kind == ActuatorKind::pair_force) {
    result.bodies = read_names(actuator, "bodies", 2, "a pair has two). Write bodies: [a, b].");
    if (!result.rest_length) std::tie(result.anchor_A_m, result.anchor_B_m) = read_anchors(actuator);
  } else if (result.kind == ActuatorKind::control) {
    result.bodies.clear();
    result.control = actuator.text("control");
  } else {
    result.bodies = {actuator.text("body")};
    result.direction = read_direction(actuator, "direction", {});
  }
  result.signal = read_signal(actuator.section("signal"), step_s, amplitude_key(result.kind, result.rest_length));
  return result;
}

ordered_json resolved_actuator(const NamedActuator& actuator) {
  ordered_json section{{"kind", name_of(drive_words, DriveWord{actuator.kind, actuator.rest_length})}};
  if (actuator.kind == ActuatorKind::pair_force) {
    section["bodies"] = actuator.bodies;
    if (!actuator.rest_length) section["anchors_m"] = resolved_anchors(actuator.anchor_A_m, actuator.anchor_B_m);
  } else if (actuator.kind == ActuatorKind::control) {
    section["control"] = actuator.control;
  } else {
    section["body"] = actuator.bodies[0];
    section["direction"] = actuator.direction;
  }
  section["signal"] = resolved_signal(actuator.signal, amplitude_key(actuator.kind, actuator.rest_length));
  return section;
}

void read_bend(Reader& bend, BendSpecification& result) {
  result.stiffness_N_m_per_rad = bend.number("stiffness_N_m_per_rad", Range::positive);
  const std::vector<std::string> keys = given(bend, {"rest_angle_rad", "rest_angle_deg"});
  if (keys.empty()) return;
  const double angle = bend.number(keys[0], Range::not_negative, std::numbers::pi);
  result.rest_angle_rad = keys[0] == "rest_angle_deg" ? angle * (std::numbers::pi / 180.0) : angle;
  if (result.rest_angle_rad > std::numbers::pi * (1.0 + 1e-6))
    bend.reject(keys[0], "is more than half a turn (an angle between two arms is at most that). Use 0 to 180°.");
  result.rest_angle_rad = std::min(result.rest_angle_rad, std::numbers::pi);
}

void add_bend(ordered_json& section, const BendSpecification& bend) {
  section["stiffness_N_m_per_rad"] = bend.stiffness_N_m_per_rad;
  section["rest_angle_rad"] = bend.rest_angle_rad;
}

NamedBend read_named_bend(Reader bend) {
  NamedBend result;
  result.bodies =
      read_names(bend, "bodies", 3, "a bend has three, the vertex in the middle). Write bodies: [a, b, c].");
  read_bend(bend, result);
  return result;
}

ordered_json resolved_named_bend(const NamedBend& bend) {
  ordered_json section{{"bodies", bend.bodies}};
  add_bend(section, bend);
  return section;
}

}  // namespace copepod::coupler
