#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/yaml/keys.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// The keys of a list that are given; reports more than one.
std::vector<std::string> given(Keys& keys, const std::vector<std::string>& names) {
  std::vector<std::string> found;
  std::ranges::copy_if(names, std::back_inserter(found), [&](const std::string& name) { return keys.has(name); });
  if (found.size() > 1)
    keys.reject(found[1], "is given together with " + found[0] + " (both set the same). Remove one.");
  return found;
}

/// A period is a whole number of steps, so that averages over a cycle are over whole cycles.
void declare_period(Keys& keys, Signal& signal, double step_s) {
  if (!given(keys, {"period_steps", "period_s"}).empty()) signal.period_steps = 1;  // where it cannot be used
  if (keys.written_if(signal.period_steps > 0))
    keys.integer(
        {"period_steps", Need::in_some_cases}, signal.period_steps, Range::positive,
        "Period T in steps; not of a constant. A table with a period repeats, one without holds its last value.");
  std::optional<double> period_s;
  keys.number("period_s", period_s, Range::positive,
              "Period in seconds instead of period_steps, rounded to whole steps.");
  if (!period_s || !(step_s > 0.0) || keys.has_errors("period_s")) return;  // those of the step are reported elsewhere
  const double steps = *period_s / step_s;
  constexpr double most_steps = 1e15;
  if (!(steps >= 1.0 && steps < most_steps))
    return keys.reject("period_s", "is " + rounded_text(steps) +
                                       " steps (at least one, and a number that can be counted). Use another period.");
  if (std::abs(steps - std::round(steps)) > 1e-6 * steps) {
    keys.problems().warn(
        keys.path_of("period_s"),
        "is " + rounded_text(steps) + " steps (a period is a whole number of steps). It is rounded to the nearest.");
  }
  signal.period_steps = std::llround(steps);
}

/// Lag in steps.
///   φ = lag_s/Δt,   φ = T lag_rad/2π,   φ = T lag_deg/360
void declare_lag(Keys& keys, Signal& signal, double step_s) {
  const std::vector<std::string> found = given(keys, {"lag_steps", "lag_s", "lag_rad", "lag_deg"});
  std::optional<double> lag_s, lag_rad, lag_deg;
  keys.number({"lag_steps", Need::in_some_cases}, signal.lag_steps, Range::any,
              "Lag in steps; whole or not. Default: 0.");
  keys.number("lag_s", lag_s, Range::any, "Lag in seconds instead of lag_steps.");
  keys.number("lag_rad", lag_rad, Range::any, "Lag as an angle [rad]: the period times lag_rad/2π.");
  keys.number("lag_deg", lag_deg, Range::any, "Lag as an angle in degrees: the period times lag_deg/360.");
  if (lag_s) signal.lag_steps = step_s > 0.0 ? *lag_s / step_s : 0.0;
  if (!lag_rad && !lag_deg) return;
  keys.reject_if(signal.period_steps == 0, found[0], "is an angle (the signal has no period). Use lag_s.");
  const double turns = lag_deg ? *lag_deg / 360.0 : *lag_rad / (2.0 * std::numbers::pi);
  signal.lag_steps = turns * static_cast<double>(signal.period_steps);
}

/// Rows "time_s,value" of a CSV file, beside the file that names it; the first row may be a header.
std::vector<Signal::Point> read_table_file(Keys& keys, double step_s) {
  const std::optional<CsvRows> rows = read_csv_rows(keys, "file", {"time_s", "value"}, {}, CsvHeader::optional);
  std::vector<Signal::Point> table;
  for (std::size_t row = 0; rows && row < rows->values.size(); ++row) {
    const double time_steps = rows->values[row][0] / step_s;
    if (!table.empty() && !(time_steps > table.back().time_steps)) {
      keys.problems().error_at({rows->path.string(), rows->lines[row]}, keys.path_of("file"),
                               "time " + rounded_text(rows->values[row][0]) +
                                   " s does not follow that of the row before (times must increase). Sort the rows.");
      return {};
    }
    table.push_back({time_steps, rows->values[row][1]});
  }
  return table;
}

/// The form of the resolved case: a run does not depend on the file.
void declare_table_lists(Keys& keys, std::vector<Signal::Point>& table) {
  const std::size_t rows = keys.reads() ? keys.size("times_steps") : table.size();
  if (keys.reads() && (rows == 0 || rows != keys.size("values")))
    return keys.reject("times_steps", "and values have " + std::to_string(rows) + " and " +
                                          std::to_string(keys.size("values")) +
                                          " entries (a table pairs them). Give as many of both, or a file.");
  table.resize(rows);
  Eigen::VectorXd times(rows), values(times.size());
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    times[row] = table[row].time_steps;
    values[row] = table[row].value;
  }
  keys.numbers({"times_steps", Need::in_some_cases}, times, "Of a table: its times in steps, instead of a file.");
  keys.numbers({"values", Need::in_some_cases}, values, "Of a table: its values at times_steps.");
  for (Eigen::Index row = 0; row < times.size(); ++row) {
    table[row] = {times[row], values[row]};
    if (row == 0 || times[row] > times[row - 1]) continue;
    keys.reject("times_steps", "contains " + rounded_text(times[row]) + " after " + rounded_text(times[row - 1]) +
                                   " (times must increase). Sort the rows.");
    return table.clear();
  }
}

void declare_table(Keys& keys, Signal& signal, double step_s) {
  keys.describe("file", {{"type", "string"}},
                "Of a table: CSV file with rows time_s,value (times increase; a header is skipped), relative to the "
                "case file. The run keeps its content.");
  if (!keys.when(signal.kind == SignalKind::table)) return;
  const bool is_file = keys.has("file"), has_values = keys.has("values");
  if (given(keys, {"file", "times_steps"}).size() > 1 && has_values) return;
  if (is_file && !(step_s > 0.0)) return;  // a step that cannot be used is reported elsewhere
  if (is_file)
    signal.table = read_table_file(keys, step_s);
  else
    declare_table_lists(keys, signal.table);
  if (signal.table.empty() || signal.period_steps == 0) return;
  const double length_steps = signal.table.back().time_steps - signal.table.front().time_steps;
  if (length_steps < static_cast<double>(signal.period_steps)) return;
  keys.reject(is_file ? "file" : "times_steps",
              "covers " + rounded_text(length_steps) + " steps, the period has " + std::to_string(signal.period_steps) +
                  " (a table that repeats ends before it starts again). Remove rows, or use a longer period.");
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

constexpr auto arm_words = words<DriveKind>("pair_force", "rest_length");

void declare_rise(Keys& keys, Signal& signal) {
  const bool is_trapezoid = signal.kind == SignalKind::trapezoid;
  if (!keys.when(is_trapezoid || keys.has("rise_fraction"))) return;
  if (keys.resolved() == nullptr) signal.rise = 0.125;
  keys.number("rise_fraction", signal.rise, Range::positive,
              "Of a trapezoid: time from 0 to the amplitude, in periods; 0.25 is a triangle wave.");
  keys.describe_also("rise_fraction", {{"maximum", 0.25}});
  keys.reject_if(signal.rise > 0.25 || !is_trapezoid, "rise_fraction",
                 "must be at most 0.25, of a trapezoid (the time from 0 to the amplitude, in periods). Use a value "
                 "such as 0.125.");
}

void declare_stop(Keys& keys, Signal& signal) {
  const char* key = "stop_step";
  if (const Value* stop = keys.raw(key); stop != nullptr && stop->text != "never")
    keys.integer(key, signal.stop_step, Range::not_negative, "");
  keys.reject_if(signal.stop_step <= signal.start_step, key,
                 "is " + std::to_string(signal.stop_step) + ", the signal starts at " +
                     std::to_string(signal.start_step) + " (it would never act). Stop later, or leave it out.");
  keys.write(key, signal.stop_step == Signal::never ? ordered_json("never") : ordered_json(signal.stop_step));
  keys.describe(key, {{"anyOf", {schema_of_integer(Range::positive), {{"const", "never"}}}}, {"default", "never"}},
                "First step in which it does not act any more.");
}

constexpr Amplitude force{"amplitude_N", "Amplitude A of a force [N]. Of a table: factor of its values, by default 1."};
constexpr Amplitude torque{"amplitude_N_m", "Amplitude of a torque [N m]."};
constexpr Amplitude rest_length{"amplitude_m", "Amplitude of a rest length [m]."};
constexpr Amplitude input{"amplitude", "Amplitude of a control, in the units of body.model.", true, true};

}  // namespace

void declare(Keys& keys, Signal& signal, double step_s, std::initializer_list<Amplitude> amplitudes) {
  if (!keys.kind(signal.kind, signal_names,
                 "constant; sinusoid: A sin(2π (t − lag)/T); square: A and −A for half a period each; trapezoid: from "
                 "0 to A within rise_fraction, held, and so on; table: linear between the rows of a table."))
    return;
  const bool is_table = signal.kind == SignalKind::table;
  for (const Amplitude& amplitude : amplitudes) {
    if (!keys.when(amplitude.applies)) continue;
    const bool has_default = is_table || amplitude.is_factor;
    if (has_default && keys.resolved() == nullptr) signal.amplitude = 1.0;
    const Key key = has_default ? Key(amplitude.key) : keys.needed(amplitude.key);
    keys.number(key, signal.amplitude, Range::any, amplitude.description);
  }
  declare_period(keys, signal, step_s);
  const bool is_constant = signal.kind == SignalKind::constant;
  keys.reject_if(is_constant && signal.period_steps > 0, keys.has("period_s") ? "period_s" : "period_steps",
                 "is given for a constant (it has no period). Remove it, or use kind: sinusoid.");
  keys.reject_if(!is_constant && !is_table && signal.period_steps == 0, "period_steps",
                 "is missing (the signal repeats). Give period_steps or period_s.");
  declare_lag(keys, signal, step_s);
  declare_rise(keys, signal);
  declare_table(keys, signal, step_s);
  keys.integer("ramp_steps", signal.ramp_steps, Range::not_negative,
               "The signal grows linearly to its full size within so many steps from its start.");
  keys.integer("start_step", signal.start_step, Range::not_negative, "First step in which it acts.");
  declare_stop(keys, signal);
}

void declare(Keys& keys, Drive& drive, double step_s) {
  if (!keys.kind(drive.kind, arm_words,
                 "pair_force: equal and opposite forces along the arm, positive ones push apart; rest_length: the "
                 "spring's rest length varies by the signal."))
    return;
  const bool is_length = drive.kind == DriveKind::rest_length;
  keys.section(required("signal"), "How it varies in time.", [&](Keys& signal) {
    declare(signal, drive.signal, step_s, {force.where(!is_length), rest_length.where(is_length)});
  });
}

void declare(Keys& keys, NamedActuator& actuator, double step_s) {
  DriveWord word{actuator.kind, actuator.rest_length};
  if (keys.resolved() == nullptr) actuator.bodies.resize(1);
  if (!keys.kind(word, drive_words,
                 "pair_force: equal and opposite, along the current line between both bodies, positive ones push "
                 "apart; rest_length: the rest length of the spring between both bodies varies by the signal; "
                 "body_force, body_torque: direction fixed to the body; world_force, world_torque: direction fixed in "
                 "the world; control: the input of an actuator of body.model."))
    return;
  actuator.kind = word.kind;
  actuator.rest_length = word.rest_length;
  const bool is_pair = word.kind == ActuatorKind::pair_force;
  const bool is_control = word.kind == ActuatorKind::control;
  if (keys.when(is_pair))
    declare_names(keys, keys.needed("bodies"), actuator.bodies, 2, "a pair has two). Write bodies: [a, b].",
                  "Names of both bodies of a pair_force or rest_length.");
  if (keys.when(is_pair && !word.rest_length))
    declare_anchors(keys, actuator.anchor_A_m, actuator.anchor_B_m,
                    "Of a pair_force: where it acts on both bodies, in their frames. Default: their centres.");
  if (keys.when(is_control)) {
    actuator.bodies.clear();
    keys.text(keys.needed("control"), actuator.control,
              "Of a control: name of the actuator in the model; the signal's amplitude is in the model's units.");
  }
  if (keys.when(!is_pair && !is_control)) {
    actuator.bodies.resize(1);
    keys.text(keys.needed("body"), actuator.bodies[0], "Name of the body of any other kind.");
    declare_direction(keys, keys.needed("direction"), actuator.direction,
                      "Direction of a force or torque, in the frame of the body or of the world; it is normalised.");
  }
  const bool turns = word.kind == ActuatorKind::body_torque || word.kind == ActuatorKind::world_torque;
  keys.section(required("signal"), "How it varies in time.", [&](Keys& signal) {
    declare(signal, actuator.signal, step_s,
            {force.where(!turns && !word.rest_length && !is_control), torque.where(turns),
             rest_length.where(word.rest_length), input.where(is_control)});
  });
}

void declare_parameters(Keys& keys, std::string& parameters) {
  const char* key = "parameters";
  keys.describe(key, {{"type", "object"}}, "What the component receives as its parameters: any values by name.");
  if (keys.resolved() != nullptr && !parameters.empty()) keys.write(key, ordered_json::parse(parameters));
  if (const Value* given = keys.mapping(key)) parameters = to_json(*given, Scalars::as_numbers).dump();
}

void declare(Keys& keys, ControllerCase& controller) {
  keys.name(required("name"), controller.name, "Name in messages, and of its files.");
  keys.command(required("command"), controller.command,
               "Command that starts it. Relative paths in it start at the directory in which `copepod run` is called.");
  keys.integer(required("every_steps"), controller.every_steps, Range::positive,
               "Steps between two actions, from step 0 on.");
  keys.words("observes", controller.bodies, 0, "Names of the bodies that it observes. Default: all.");
  keys.words(required("sets"), controller.actuators, 0,
             "Key paths of what it sets: actuators.0, joints.1, swimmers.0.arms.0. Its signal acts "
             "until the first action.");
  declare_parameters(keys, controller.parameters);
}

void declare(Keys& keys, BendSpecification& bend) {
  keys.number(required("stiffness_N_m_per_rad"), bend.stiffness_N_m_per_rad, Range::positive,
              "Stiffness κ of the energy κ (θ − θ₀)²/2.");
  const std::vector<std::string> found = given(keys, {"rest_angle_rad", "rest_angle_deg"});
  keys.number({"rest_angle_rad", Need::in_some_cases}, bend.rest_angle_rad, Range::not_negative,
              "Rest angle θ₀ [rad]. Default: π, straight.");
  std::optional<double> angle_deg;
  keys.number("rest_angle_deg", angle_deg, Range::not_negative, "Rest angle in degrees.");
  if (angle_deg) bend.rest_angle_rad = *angle_deg * (std::numbers::pi / 180.0);
  if (bend.rest_angle_rad > std::numbers::pi * (1.0 + 1e-6))
    keys.reject(found[0], "is more than half a turn (an angle between two arms is at most that). Use 0 to 180°.");
  bend.rest_angle_rad = std::min(bend.rest_angle_rad, std::numbers::pi);
}

void declare(Keys& keys, NamedBend& bend) {
  declare_names(keys, required("bodies"), bend.bodies, 3,
                "a bend has three, the vertex in the middle). Write bodies: [a, b, c].",
                "Names of three bodies, the vertex in the middle.");
  declare(keys, static_cast<BendSpecification&>(bend));
}

}  // namespace copepod::coupler
