#include <algorithm>
#include <concepts>
#include <type_traits>

#include <nlohmann/json.hpp>

#include "checkpoint/checkpoint_store.hpp"
#include "contract/errors.hpp"
#include "conversion/members.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

// JSON numbers are printed as the shortest text that reads back to the same bits, so text keeps every bit.

template <typename Derived>
ordered_json encoded(const Eigen::PlainObjectBase<Derived>& matrix) {
  return std::vector<double>(matrix.data(), matrix.data() + matrix.size());
}
ordered_json encoded(double number) { return number; }
ordered_json encoded(std::int64_t number) { return number; }
ordered_json encoded(const std::optional<double>& number) { return number ? ordered_json(*number) : nullptr; }

/// Columns of a matrix with a given number of rows, elements of a vector.
template <typename Derived>
void decode(const ordered_json& json, Eigen::PlainObjectBase<Derived>& matrix) {
  const auto numbers = json.get<std::vector<double>>();
  constexpr Eigen::Index rows = Derived::RowsAtCompileTime == Eigen::Dynamic ? 1 : Derived::RowsAtCompileTime;
  const auto count = static_cast<Eigen::Index>(numbers.size());
  const bool fits = Derived::SizeAtCompileTime == Eigen::Dynamic ? count % rows == 0 : count == matrix.size();
  if (!fits) throw StorageError("a list of a checkpoint is incomplete (damaged). Use another one.");
  if constexpr (Derived::SizeAtCompileTime == Eigen::Dynamic)
    matrix.resize(Derived::RowsAtCompileTime == Eigen::Dynamic ? count : rows,
                  Derived::RowsAtCompileTime == Eigen::Dynamic ? 1 : count / rows);
  std::copy(numbers.begin(), numbers.end(), matrix.data());
}
void decode(const ordered_json& json, double& number) { json.get_to(number); }
void decode(const ordered_json& json, std::int64_t& number) { number = whole_number<std::int64_t>(json); }
void decode(const ordered_json& json, std::optional<double>& number) {
  number = json.is_null() ? std::nullopt : std::optional(json.get<double>());
}

/// A struct of the state, constant where it is only read.
template <class T, class Struct>
concept Is = std::same_as<std::remove_const_t<T>, Struct>;

// Each calls `visit` with name and value of every member, in either direction.

void visit_members(Is<Loads> auto& loads, const auto& visit) {
  COPEPOD_MEMBERS(visit, loads, step, force_N, torque_N_m, flow);
}

void visit_members(Is<Kinematics> auto& kinematics, const auto& visit) {
  COPEPOD_MEMBERS(visit, kinematics, step, position_m, orientation_wxyz, velocity_m_per_s, angular_velocity_rad_per_s);
}

void visit_members(Is<Cycle> auto& cycle, const auto& visit) {
  COPEPOD_MEMBERS(visit, cycle, number, centroid_m, turned, translation_m, rotation, displacement_m, arms, power_W,
                  dissipation_W, power_as_in_paper_W, max_speed_m_per_s, max_speed_along_m_per_s);
}

void visit_members(Is<CycleSums> auto& sums, const auto& visit) {
  COPEPOD_MEMBERS(visit, sums, number, samples, turned, first_position_m, first_arm_m, arm_m, arm_cosine_m, arm_sine_m,
                  power_W, dissipation_W, power_as_in_paper_W, max_speed_m_per_s, max_speed_along_m_per_s, last,
                  before_last, latest_along_m);
}

void visit_members(Is<BalanceSums> auto& sums, const auto& visit) {
  COPEPOD_MEMBERS(visit, sums, start_kg_m_per_s, from_fluid_N_s, from_drive_N_s, withheld_N_s, exchanged_N_s, start_J,
                  from_fluid_J, from_drive_J);
}

void visit_members(Is<DrivingProtocol::Way> auto& way, const auto& visit) {
  COPEPOD_MEMBERS(visit, way, summed_steps, steps, excess);
}

template <typename Members>
requires std::is_aggregate_v<Members> ordered_json encoded(const Members& members) {
  ordered_json json;
  visit_members(members, [&](const char* name, const auto& value) { json[name] = encoded(value); });
  return json;
}

template <typename Members>
requires std::is_aggregate_v<Members>
void decode(const ordered_json& json, Members& members) {
  visit_members(members, [&](const char* name, auto& value) { decode(json.at(name), value); });
}

}  // namespace

template <class Integer>
Integer whole_number(const ordered_json& json) {
  if (!json.is_number_integer())
    throw StorageError("a checkpoint has " + json.dump(-1, ' ', false, ordered_json::error_handler_t::replace) +
                       " for a whole number (damaged). Use another one.");
  return json.get<Integer>();
}
template std::int64_t whole_number(const ordered_json&);
template std::uint64_t whole_number(const ordered_json&);

ordered_json to_json(const CouplerState& state) {
  ordered_json swimmers = ordered_json::array();
  for (const CycleSums& sums : state.swimmers) swimmers.push_back(encoded(sums));
  ordered_json ways = ordered_json::array();
  for (const DrivingProtocol::Way& way : state.ways) ways.push_back(encoded(way));
  ordered_json tables = ordered_json::object();
  for (const auto& [name, end] : state.tables) tables[name] = {{"bytes", end.bytes}, {"checksum", end.checksum}};
  return {{"step", state.step},
          {"first_step", state.first_step},
          {"previous_loads", encoded(state.previous_loads)},
          {"previous_kinematics", encoded(state.previous_kinematics)},
          {"swimmers", swimmers},
          {"balance", encoded(state.balance)},
          {"tables", tables},
          {"mean", {{"start", state.mean.start}, {"every_steps", state.mean.every_steps}}},
          {"loads", encoded(state.loads)},
          {"steered", state.steered},
          {"ways", ways},
          {"components", {{"fluid", state.fluid_component}, {"body", state.body_component}}}};
}

CouplerState coupler_state_from_json(const ordered_json& json) {
  try {
    CouplerState state;
    state.step = whole_number<std::int64_t>(json.at("step"));
    state.first_step = whole_number<std::int64_t>(json.at("first_step"));
    decode(json.at("previous_loads"), state.previous_loads);
    decode(json.at("previous_kinematics"), state.previous_kinematics);
    for (const ordered_json& swimmer : json.at("swimmers")) decode(swimmer, state.swimmers.emplace_back());
    decode(json.at("balance"), state.balance);
    for (const auto& [name, end] : json.at("tables").items())
      state.tables[name] = {whole_number<std::uint64_t>(end.at("bytes")),
                            whole_number<std::uint64_t>(end.at("checksum"))};
    const ordered_json& mean = json.at("mean");
    state.mean = {whole_number<std::int64_t>(mean.at("start")), whole_number<std::int64_t>(mean.at("every_steps"))};
    decode(json.at("loads"), state.loads);
    json.at("steered").get_to(state.steered);
    for (const ordered_json& way : json.at("ways")) decode(way, state.ways.emplace_back());
    json.at("components").at("fluid").get_to(state.fluid_component);
    json.at("components").at("body").get_to(state.body_component);
    return state;
  } catch (const ordered_json::exception& error) {
    throw StorageError(std::string("coupler.json of a checkpoint is unusable (") + error.what() +
                       "). Use another one.");
  }
}

}  // namespace copepod::coupler
