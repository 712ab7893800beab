#pragma once

#include <string>

#include "config/yaml/document.hpp"

namespace copepod::coupler {

/// Reads YAML into a tree of values with their line numbers.
/// @param source  what messages call the text: the path of the file, or the option it came from
/// @param lines   whether line numbers mean something there (not for an option of the command line)
enum class LineNumbers { kept, dropped };
/// @throws CaseInvalid with file:line if the text is not YAML, is too large, or repeats a key
Value parse_yaml(const std::string& text, const std::string& source, LineNumbers lines);

/// YAML text of a tree; parse_yaml gives back an equal tree.
std::string to_yaml(const nlohmann::ordered_json& value);

}  // namespace copepod::coupler
