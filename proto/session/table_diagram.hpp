#pragma once

#include <string>

namespace copepod::session {

/// The transition table as a Mermaid state diagram, for docs/protocol.md: one arrow per pair of states with
/// all the messages that lead from one to the other, "request → reply (role)".
std::string table_as_mermaid();

}  // namespace copepod::session
