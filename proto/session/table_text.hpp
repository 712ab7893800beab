#pragma once

#include <string>

namespace copepod::session {

/// The transition table as a Markdown table, for docs/protocol.md.
std::string table_as_markdown();

/// The transition table as JSON, for components and tests in other languages: a list of objects with roles,
/// from (states), message or event, to (state; absent if it does not change), work, reply (absent if none).
std::string table_as_json();

/// All feature names (contract/features.hpp), likewise; as JSON a list of objects with name, kind, meaning.
std::string features_as_markdown();
std::string features_as_json();

}  // namespace copepod::session
