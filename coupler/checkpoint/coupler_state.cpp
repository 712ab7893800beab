#include "checkpoint/coupler_state.hpp"

#include <algorithm>

#include <nlohmann/json.hpp>

#include "checkpoint/whole_number.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

// JSON numbers are printed as the shortest text that reads back to the same bits, so text keeps every bit.

ordered_json list(const Eigen::Matrix3Xd& matrix) {
  return std::vector<double>(matrix.data(), matrix.data() + matrix.size());
}

Eigen::Matrix3Xd matrix(const ordered_json& json) {
  const auto numbers = json.get<std::vector<double>>();
  Eigen::Matrix3Xd result(3, static_cast<Eigen::Index>(numbers.size() / 3));
  if (numbers.size() % 3 != 0) throw StorageError("loads of a checkpoint are incomplete (damaged). Use another one.");
  std::copy(numbers.begin(), numbers.end(), result.data());
  return result;
}

ordered_json to_json(const PeriodSums& sums) {
  return {{"first_position_m", sums.first_position_m},
          {"last_position_m", sums.last_position_m},
          {"arm_m", sums.arm_m},
          {"arm_cosine_m", sums.arm_cosine_m},
          {"arm_sine_m", sums.arm_sine_m},
          {"first_arm_m", sums.first_arm_m},
          {"power_W", sums.power_W},
          {"power_rounded_omega_W", sums.power_rounded_omega_W},
          {"max_speed_m_per_s", sums.max_speed_m_per_s},
          {"samples", sums.samples},
          {"complete", sums.complete}};
}

PeriodSums period_sums(const ordered_json& json) {
  PeriodSums sums;
  json.at("first_position_m").get_to(sums.first_position_m);
  json.at("last_position_m").get_to(sums.last_position_m);
  json.at("arm_m").get_to(sums.arm_m);
  json.at("arm_cosine_m").get_to(sums.arm_cosine_m);
  json.at("arm_sine_m").get_to(sums.arm_sine_m);
  json.at("first_arm_m").get_to(sums.first_arm_m);
  json.at("power_W").get_to(sums.power_W);
  json.at("power_rounded_omega_W").get_to(sums.power_rounded_omega_W);
  json.at("max_speed_m_per_s").get_to(sums.max_speed_m_per_s);
  sums.samples = whole_number<std::int64_t>(json.at("samples"));
  json.at("complete").get_to(sums.complete);
  return sums;
}

}  // namespace

ordered_json to_json(const CouplerState& state) {
  ordered_json swimmers = ordered_json::array();
  for (const PeriodSums& sums : state.swimmers) swimmers.push_back(to_json(sums));
  return {{"step", state.step},
          {"previous_loads",
           {{"step", state.previous_loads.step},
            {"force_N", list(state.previous_loads.force_N)},
            {"torque_N_m", list(state.previous_loads.torque_N_m)}}},
          {"swimmers", swimmers},
          {"mean", {{"start", state.mean.start}, {"every_steps", state.mean.every_steps}}},
          {"components", {{"fluid", state.fluid_component}, {"body", state.body_component}}}};
}

CouplerState coupler_state_from_json(const ordered_json& json) {
  try {
    CouplerState state;
    state.step = whole_number<std::int64_t>(json.at("step"));
    const ordered_json& loads = json.at("previous_loads");
    state.previous_loads.step = whole_number<std::int64_t>(loads.at("step"));
    state.previous_loads.force_N = matrix(loads.at("force_N"));
    state.previous_loads.torque_N_m = matrix(loads.at("torque_N_m"));
    for (const ordered_json& swimmer : json.at("swimmers")) state.swimmers.push_back(period_sums(swimmer));
    const ordered_json& mean = json.at("mean");
    state.mean = {whole_number<std::int64_t>(mean.at("start")), whole_number<std::int64_t>(mean.at("every_steps"))};
    const ordered_json components = json.value("components", ordered_json::object());  // absent in older ones
    state.fluid_component = components.value("fluid", "");
    state.body_component = components.value("body", "");
    return state;
  } catch (const ordered_json::exception& error) {
    throw StorageError(std::string("coupler.json of a checkpoint is unusable (") + error.what() +
                       "). Use another one.");
  }
}

}  // namespace copepod::coupler
