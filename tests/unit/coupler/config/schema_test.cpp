#include <fstream>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/campaign.hpp"
#include "config/load_case.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::json;

/// Collects the key paths that a schema describes, and those that lack a description.
class SchemaKeys {
 public:
  explicit SchemaKeys(json schema) : schema_(std::move(schema)) { collect(schema_, ""); }
  std::set<std::string> keys;
  std::set<std::string> undescribed;

 private:
  void collect(const json& node, const std::string& path) {
    if (node.contains("$ref")) collect(referred(node), path);
    for (const auto& option : node.value("anyOf", json::array())) collect(option, path);
    if (node.contains("items")) collect(node["items"], path + ".[]");
    if (node.contains("additionalProperties") && node["additionalProperties"].is_object()) {
      keys.insert(path + ".*");
      collect(node["additionalProperties"], path + ".*");
    }
    const json properties = node.value("properties", json::object());
    for (const auto& [key, child] : properties.items()) {
      const std::string below = path.empty() ? key : path + "." + key;
      keys.insert(below);
      if (!child.contains("description") && !(child.contains("$ref") && referred(child).contains("description")))
        undescribed.insert(below);
      collect(child, below);
    }
  }
  /// What "#/$defs/…" stands for.
  [[nodiscard]] const json& referred(const json& node) const {
    return schema_.at(json::json_pointer(node["$ref"].get<std::string>().substr(1)));
  }
  json schema_;
};

/// Parser and schema have the same keys, and the schema describes each.
void expect_described(const AskedKeys& asked, const std::string& file) {
  const SchemaKeys schema(json::parse(content_of(std::string(CONFIGS) + "/schema/" + file)));
  for (const std::string& key : asked) EXPECT_TRUE(schema.keys.contains(key)) << key << " is missing in the schema";
  for (const std::string& key : schema.keys) EXPECT_TRUE(asked.contains(key)) << key << " is unknown to the parser";
  EXPECT_TRUE(schema.undescribed.empty()) << testing::PrintToString(schema.undescribed);
}

TEST(Schema, DescribesExactlyTheKeysThatTheParserLooksFor) {
  AskedKeys asked;
  const std::string text = content_of(std::string(CONFIG_TESTS) + "/every_key.yaml");
  load_case_text(text, "every_key.yaml", {}, &asked);
  load_case_text(text, "every_key.yaml", {"fluid.solver={command: my_fluid}", "body.solver={command: [a, b]}"}, &asked);
  // A face can be written in several ways; no single case has them all.
  for (const std::string& condition : {std::string("{velocity_m_per_s: [0, 0, 0]}"), std::string("{pressure_Pa: 0}")}) {
    for (const std::string& faces : {condition, "{low: " + condition + ", high: " + condition + "}"}) {
      const std::string boundaries = "{x: " + faces + ", y: " + faces + ", z: " + faces + "}";
      load_case_text(text, "every_key.yaml", {"fluid.boundaries=" + boundaries}, &asked);
    }
  }
  load_case_text(text, "every_key.yaml", {"swimmers.0.spring={stiffness_N_per_m: 10, damping_ratio: 0.07}"}, &asked);
  const std::string signal = "{kind: table, file: " + std::string(CONFIG_TESTS) +
                             "/tables/two_rows.csv, amplitude_N: 1.0e-12, period_s: 1.0e-6, ";
  for (const std::string lag : {"lag_s: 0", "lag_rad: 0"})
    load_case_text(text, "every_key.yaml",
                   {"actuators.0.signal=" + signal + lag + "}", "swimmers.1.arms.0.drive.signal=" + signal + lag + "}"},
                   &asked);
  load_case_text(text, "every_key.yaml",
                 {"fluid.boundaries={x: periodic, y: periodic}", "fluid.symmetry_planes=[]",
                  "fluid.initial_flow={kind: taylor_green, speed_m_per_s: 0.2}"},
                 &asked);
  // Both forms of a swimmer are templates; the rest of the template's keys is read like that of a swimmer.
  const std::string swarm =
      ", count: 1, region_m: {x: [1.0e-5, 4.0e-5], y: [1.0e-6, 2.0e-5], z: [5.0e-5, 7.0e-5]}, placement: random, "
      "orientations: aligned, spread_deg: 5, phases: random, minimal_gap_m: 1.0e-6, seed: 2}";
  const std::string pair =
      "swarm={template: {name: pair, beads: [{name: A, radius_m: 1.0e-6, mass_kg: 1.0e-14}, {name: B, radius_m: "
      "1.0e-6, mass_kg: 1.0e-14}], arms: [{beads: [A, B], spring: {stiffness_N_per_m: 1, rest_gap_m: 2.0e-6}}]}";
  const std::string row =
      "swarm={template: {name: row, beads: [{radius_m: 1.0e-6}, {radius_m: 1.0e-6}, {radius_m: 1.0e-6}], bead_mass_kg: "
      "1.0e-14, rest_gap_m: [2.0e-6, 2.0e-6], spring: {stiffness_N_per_m: 1}, stroke: {amplitude_N: 1.0e-8, "
      "period_steps: 4000, phase_lag_steps: 1000, cycles: 1}}";
  for (const std::string& form : {pair, row})
    load_case_text(text, "every_key.yaml", {"fluid.symmetry_planes=[]", form + swarm}, &asked);
  for (const std::string& key : AskedKeys(asked)) {
    const std::string list = "swimmers.[].";
    if (key.starts_with(list)) asked.insert("swarm.template." + key.substr(list.size()));
  }
  // What acts on the body has no place beside a motion in time.
  const std::vector<std::string> unattached{"bodies.0.velocity_m_per_s=null",
                                            "bodies.0.angular_velocity_rad_per_s=null", "springs=[]", "actuators=[]"};
  for (const std::string& wave :
       {"{kind: table, file: " + std::string(CONFIG_TESTS) + "/tables/two_rows.csv, period_s: 1.0e-6, lag_s: 0}",
        std::string("{kind: table, times_steps: [0, 50], values: [0, 1], period_steps: 100, lag_rad: 0}"),
        std::string("{kind: trapezoid, amplitude: 2, period_steps: 100, rise_fraction: 0.2, lag_deg: 90}"),
        std::string("{kind: sinusoid, period_steps: 100, lag_steps: 1, ramp_steps: 1, start_step: 1, stop_step: 9}")}) {
    std::vector<std::string> overrides = unattached;
    overrides.push_back("bodies.0.motion={prescribed: {velocity_m_per_s: [0, 0, 0.1], signal: " + wave + "}}");
    load_case_text(text, "every_key.yaml", overrides, &asked);
  }
  expect_described(asked, "case.schema.json");
  EXPECT_GT(asked.size(), 80U);
}

TEST(Schema, DescribesExactlyTheKeysOfACampaign) {
  AskedKeys asked;
  load_campaign_text("campaign: every_key\njobs: 2\ncases:\n  - {case: a.yaml, name: b, set: {run.steps: 10}}\n",
                     "every_key.yaml", &asked);
  expect_described(asked, "campaign.schema.json");
}

}  // namespace
}  // namespace copepod::coupler
