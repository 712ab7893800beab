#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "config/load_case.hpp"
#include "config/sections/case.hpp"
#include "contract/capabilities.hpp"
#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "storage/run_directory.hpp"

namespace copepod::coupler {

/// Keys of the resolved cases whose values differ: "fluid.cell_size_m" → {"1e-06", "2e-06"}; "none" where one lacks the
/// key. Length of the run, output, services and published figures do not count: a run is continued with others.
using ChangedKeys = std::map<std::string, std::pair<std::string, std::string>>;

ChangedKeys changed_keys(const Case& before, const Case& now);

/// A run is continued with its own case only.
/// @param directory  of the run
/// @throws CaseError that names the keys that differ
void require_same_case(const std::filesystem::path& directory, const Case& now);

/// Where a run begins that starts a changed case from a checkpoint of another run.
struct Branch {
  std::filesystem::path directory;   ///< of the other run
  std::optional<std::int64_t> step;  ///< of the checkpoint; absent: the newest
  std::string case_key;              ///< of the other run's case
  ChangedKeys changed;
};

/// Finds out whether a state of the run in `directory` can be one of this case: bodies, their shapes, lattice and step
/// must be the same.
/// @throws CaseError
Branch plan_branch(const std::filesystem::path& directory, std::optional<std::int64_t> step, const LoadedCase& now);

/// What this program was built from and with.
struct BuildInfo {
  std::string version;
  std::string git_revision;  ///< with "-dirty" if the tree had changes; "unknown" outside a checkout
  std::string compiler;
  std::string build_type;
};

const BuildInfo& build_info();

/// Where the results of a run come from: provenance.json, written at the start and again at the end, so that
/// a run that was killed is still described.
class Provenance {
 public:
  /// @param build  identifies the programs of the run; empty: unknown
  Provenance(const RunDirectory& directory, const std::string& command_line, const std::string& build, int fluid_ranks,
             bool resumed);

  void set_components(const std::map<std::string, Capabilities>& all) {
    for (const auto& [role, each] : all) content_["components"][role] = each.name + " " + each.version;
  }
  /// @param step  of the checkpoint that the run starts from
  void set_branch(const Branch& branch, std::int64_t step);
  /// @param notices  features that a component neglects, and the like
  void set_notices(const std::vector<std::string>& notices) { content_["notices"] = notices; }
  void write() const;
  void write_end(ExitCode code, const std::string& reason);

 private:
  std::filesystem::path file_;
  nlohmann::ordered_json content_;
};

/// Where the time of a run went; seconds of wall time.
struct RunTiming {
  std::int64_t first_step = 0;  ///< not 0 where a checkpoint was resumed
  double loop_s = 0.0;          ///< from the first exchange until the fluid had nothing left to do
  double fluid_wait_s = 0.0;    ///< the coupler waited for the fluid
  double body_wait_s = 0.0;     ///< the coupler waited for the bodies
};

/// Digest of a whole run: of the fluid's state, the bodies' state and the final kinematics, in this order.
std::uint64_t run_digest(const SolverSummary& fluid, const SolverSummary& body, const Kinematics& kinematics);

/// Content of summary.json (docs: "The run directory").
/// @param swimmers  its keys about swimmers, and the balance of the bodies
nlohmann::ordered_json make_summary(const Case& the_case, std::int64_t steps_done, const SolverSummary& fluid,
                                    const SolverSummary& body, const Kinematics& kinematics, const RunTiming& timing,
                                    const nlohmann::ordered_json& swimmers);

}  // namespace copepod::coupler
