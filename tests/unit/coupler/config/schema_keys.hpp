#pragma once

#include <map>
#include <string>

#include <nlohmann/json.hpp>

namespace copepod::coupler {

/// Key paths of a schema and their descriptions: list positions are "[]", keys of the user's own "*".
inline void collect_keys(const nlohmann::ordered_json& node, const std::string& path,
                         std::map<std::string, std::string>& keys) {
  using nlohmann::ordered_json;
  for (const auto& form : node.value("anyOf", ordered_json::array())) collect_keys(form, path, keys);
  if (node.contains("items")) collect_keys(node["items"], path + ".[]", keys);
  if (node.contains("additionalProperties") && node["additionalProperties"].is_object())
    collect_keys(node["additionalProperties"], path + ".*", keys);
  if (!node.contains("properties")) return;
  for (const auto& [key, child] : node["properties"].items()) {
    const std::string below = path.empty() ? key : path + "." + key;
    keys[below] = child.value("description", "");
    collect_keys(child, below, keys);
  }
}

inline std::map<std::string, std::string> keys_of(const nlohmann::ordered_json& schema) {
  std::map<std::string, std::string> keys;
  collect_keys(schema, "", keys);
  return keys;
}

}  // namespace copepod::coupler
