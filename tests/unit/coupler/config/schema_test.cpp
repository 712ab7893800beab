#include <algorithm>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "config/load_case.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "temporary_folder.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

std::string in_the_checkout(const std::string& name) {
  return content_of(std::string(CONFIGS) + "/schema/" + name + ".schema.json");
}

TEST(Schema, IsWhatTheCouplerPrints) {
  EXPECT_EQ(in_the_checkout("case"), case_schema().dump(1) + "\n")
      << "Write it again: build/bin/coupler --schema case > configs/schema/case.schema.json";
  EXPECT_EQ(in_the_checkout("campaign"), campaign_schema().dump(1) + "\n")
      << "Write it again: build/bin/coupler --schema campaign > configs/schema/campaign.schema.json";
}

void expect_descriptions(const ordered_json& node, const std::string& path) {
  for (const auto& form : node.value("anyOf", ordered_json::array())) expect_descriptions(form, path);
  for (const char* below : {"items", "additionalProperties"})
    if (node.contains(below) && node[below].is_object()) expect_descriptions(node[below], path + ".[]");
  const ordered_json properties = node.value("properties", ordered_json::object());
  for (const auto& [key, child] : properties.items()) {
    const std::string description = child.value("description", "");
    EXPECT_TRUE(description.ends_with('.') || description.ends_with('"')) << path << "." << key << ": " << description;
    expect_descriptions(child, path + "." + key);
  }
}

TEST(Schema, DescribesEveryKey) {
  for (const auto& schema : {case_schema(), campaign_schema()}) expect_descriptions(schema, "");
}

const std::string table = "{kind: table, times_steps: [0, 50], values: [0, 1]}";

/// Forms of the case every_key.yaml that have every section between them.
const std::vector<std::vector<std::string>> forms{
    {},
    {"fluid.solver={command: my_fluid}", "body.solver={command: [a, b]}"},
    {"fluid.boundaries={x: {pressure_Pa: 0}, y: {pressure_Pa: 0}, z: {pressure_Pa: 0}}"},
    {"fluid.boundaries={x: {low: {pressure_Pa: 0}, high: {pressure_Pa: 0}}, y: {low: {pressure_Pa: 0}, high: "
     "{pressure_Pa: "
     "0}}, z: {low: {pressure_Pa: 0}, high: {pressure_Pa: 0}}}"},
    {"fluid.boundaries={x: {velocity_m_per_s: [1, 0, 0], signal: {}}, y: {velocity_m_per_s: [0, 1, 0], signal: {}}, z: "
     "{velocity_m_per_s: [0, 0, 1], signal: {}}}"},
    {"fluid.boundaries={x: {low: {velocity_m_per_s: [1, 0, 0], signal: {}}, high: {velocity_m_per_s: [1, 0, 0], "
     "signal: "
     "{}}}, y: {low: {velocity_m_per_s: [0, 1, 0], signal: {}}, high: {velocity_m_per_s: [0, 1, 0], signal: {}}}, z: "
     "{low: {velocity_m_per_s: [0, 0, 1], signal: {}}, high: {velocity_m_per_s: [0, 0, 1], signal: {}}}}"},
    {"fluid.boundaries={x: {outflow: {}}, y: {outflow: {}}, z: {outflow: {}}}"},
    {"fluid.boundaries={x: {low: {outflow: {}}, high: {outflow: {}}}, y: {low: {outflow: {}}, high: {outflow: {}}}, z: "
     "{low: {outflow: {}}, high: {outflow: {}}}}"},
    {"fluid.initial_flow={kind: taylor_green}", "output.bodies={}"},
    {"fluid.boundaries={x: {velocity_m_per_s: [1, 0, 0], profile: {factors: [1]}}, y: {velocity_m_per_s: [0, 1, 0], "
     "profile: {factors: [1]}}, "
     "z: {velocity_m_per_s: [0, 0, 1], profile: {factors: [1]}}}"},
    {"fluid.boundaries={x: {low: {velocity_m_per_s: [1, 0, 0], profile: {factors: [1]}}, high: {velocity_m_per_s: [1, "
     "0, 0], "
     "profile: {factors: [1]}}}, y: {low: {velocity_m_per_s: [0, 1, 0], profile: {factors: [1]}}, high: "
     "{velocity_m_per_s: [0, 1, 0], profile: "
     "{factors: [1]}}}, z: {low: {velocity_m_per_s: [0, 0, 1], profile: {factors: [1]}}, high: {velocity_m_per_s: [0, "
     "0, 1], profile: {factors: [1]}}}}"},
    {"fluid.initial_flow={kind: file}"},
    {"swimmers.1.arms.0.drive.signal=" + table, "bodies.0.motion={prescribed: {signal: " + table + "}}"},
    {"swarm={template: {name: row, beads: [{}, {}, {}], spring: {}, stroke: {}, published: {Re_bodies: {}}}, "
     "placement: "
     "file, region_m: {}}"},
    {"swarm={template: {name: pair, beads: [{name: A}, {name: B}], bends: [{}], arms: [{spring: {}, drive: {kind: "
     "pair_force, "
     "signal: " +
     table + "}}, {drive: {kind: rest_length, signal: " + table + "}}]}}"},
    {"swimmers.1.beads.0={shape: compound, parts: [{}]}", "obstacles=[{shape: compound, parts: [{}]}]",
     "swarm={template: {name: pair, beads: [{name: A, shape: compound, parts: [{}]}, {name: B}]}}"},
};

/// Adds every key that a schema has to a tree, as null: absent, but known or not. @throws for a key that it lacks
void complete(ordered_json& node, const ordered_json& schema, const std::string& path, std::set<std::string>& offered) {
  if (node.is_array() && schema.contains("items")) {
    for (std::size_t i = 0; i < node.size(); ++i)
      complete(node[i], schema["items"], path + "." + std::to_string(i), offered);
  }
  if (schema.contains("anyOf")) {
    for (const ordered_json& form : schema["anyOf"]) {
      const bool is_this = node.is_array() || std::ranges::any_of(node.items(), [&](const auto& entry) {
                             return form.value("properties", ordered_json()).contains(entry.key());
                           });
      if (is_this) complete(node, form, path, offered);
    }
  }
  if (!node.is_object() || !schema.contains("properties")) return;
  for (const auto& [key, value] : node.items())
    if (!schema["properties"].contains(key)) throw std::runtime_error(path + "." + key + " is not in the schema");
  for (const auto& [key, child] : schema["properties"].items()) {
    const std::string below = path.empty() ? key : path + "." + key;
    offered.insert(below);
    if (node.contains(key))
      complete(node[key], child, below, offered);
    else
      node[key] = nullptr;
  }
}

/// "swimmers.0.beads.1" is about "swimmers.[].beads.[]".
std::string general(const std::string& path) {
  static const std::regex place("\\.[0-9]+(?=\\.|$)");
  return std::regex_replace(path, place, ".[]");
}

/// Exact paths of the keys that are unknown to the parser.
std::set<std::string> unknown_in(const std::string& text) {
  std::set<std::string> paths;
  try {
    load_case_text(text, "every_key.yaml", {});
  } catch (const CaseInvalid& invalid) {
    static const std::regex form("key '([^']+)' is unknown \\(nothing (?:at the top of the case|in (\\S+)) has");
    for (const std::string& line : invalid.lines()) {
      std::smatch parts;
      if (std::regex_search(line, parts, form))
        paths.insert((parts[2].matched ? parts[2].str() + "." : "") + parts[1].str());
    }
  }
  return paths;
}

TEST(Schema, HasTheKeysOfTheParserAndNoOthers) {
  const std::string text = content_of(std::string(CONFIG_TESTS) + "/every_key.yaml");
  std::set<std::string> known;
  for (std::vector<std::string> form : forms) {
    form.emplace_back("sweep=null");
    ordered_json tree = to_json(Document::parse(text, "every_key.yaml", form).root());
    std::set<std::string> offered;
    complete(tree, case_schema(), "", offered);
    const std::set<std::string> unknown = unknown_in(to_yaml(tree));
    for (const std::string& path : offered)
      if (!unknown.contains(path)) known.insert(general(path));
  }
  for (const std::string& key : case_keys())
    EXPECT_TRUE(known.contains(key) || key.starts_with("sweep.")) << key << " is unknown to the parser";
}

}  // namespace
}  // namespace copepod::coupler
