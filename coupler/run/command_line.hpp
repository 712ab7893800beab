#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace copepod::coupler {

/// What the coupler was asked to do.
struct Options {
  enum class Action { plan, run, schema, nothing };  ///< nothing: --help or --version was answered

  Action action = Action::nothing;
  std::string case_file;               ///< to plan also a campaign file
  std::string schema;                  ///< of a case or of a campaign
  std::vector<std::string> overrides;  ///< of --set, --ranks, --fluid and --body, as "key.path=value"
  std::string out;                     ///< run directory
  std::string endpoint;
  std::string session;
  std::string key_file;  ///< CURVE keys of the coupler; empty: none
  std::string log_file;
  std::string build;      ///< identifies the programs of the run, for the provenance
  std::string wire_file;  ///< where messages are recorded; of the case, empty: nowhere
  bool resume = false;
  std::string branch_from;                  ///< directory of the run from whose checkpoint this one starts
  std::optional<std::int64_t> branch_step;  ///< of that checkpoint; absent: the newest
  std::string command_line;                 ///< all arguments but the token, for the provenance
};

/// @throws CaseError (exit code 2) if the arguments make no sense
Options parse_command_line(int argc, const char* const* argv);

}  // namespace copepod::coupler
