#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "config/load_case.hpp"
#include "config/sections/case.hpp"
#include "run/checkpointer.hpp"
#include "run/components.hpp"
#include "run/run_case.hpp"

namespace copepod::coupler {

/// What the coupler was asked to do.
struct Options {
  enum class Action { plan, run, schema, nothing };  ///< nothing: --help or --version was answered

  Action action = Action::nothing;
  std::string case_file;               ///< to plan also a campaign file
  bool surfaces = false;               ///< of bodies and obstacles, in a plan
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

/// The component, place and cause of a failure.
/// @param step  that was being computed
FailureReport report_of(const std::exception& error, std::int64_t step);

/// @throws CaseError (exit code 2) if the arguments make no sense
Options parse_command_line(int argc, const char* const* argv);

/// @param signals  of the run; outlives the components
using MakeComponents =
    std::function<std::unique_ptr<Components>(const Options&, const Case&, const RunSignals& signals)>;

/// The coupler program: plans or runs a case and turns whatever happens into events and an exit code.
/// @param out   plan, or events of the run, one JSON object per line
/// @param err   one line per error
/// @return exit code of the process
int run_program(int argc, const char* const* argv, std::ostream& out, std::ostream& err,
                const MakeComponents& make_components);

/// The description of a case for the deploy command: how to start it, what it requires and costs from there on.
nlohmann::ordered_json make_plan(const LoadedCase& loaded, Beginning beginning);

/// The same for a campaign: its name, how many cases at once (null: not given), and name, file and settings
/// of each case.
nlohmann::ordered_json make_campaign_plan(const Campaign& campaign);

/// What pages draw: bodies by the numbers of their surfaces, which those of equal shape share, and obstacles.
nlohmann::ordered_json surfaces_of(const LoadedCase& loaded);

}  // namespace copepod::coupler
