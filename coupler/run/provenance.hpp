#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "contract/capabilities.hpp"
#include "contract/errors.hpp"
#include "run/branch.hpp"
#include "storage/run_directory.hpp"

namespace copepod::coupler {

/// Where the results of a run come from: provenance.json, written at the start and again at the end, so that
/// a run that was killed is still described.
class Provenance {
 public:
  /// @param build  identifies the programs of the run; empty: unknown
  Provenance(const RunDirectory& directory, std::string command_line, std::string build, int fluid_ranks, bool resumed);

  void set_components(const Capabilities& fluid, const Capabilities& body);
  /// @param step  of the checkpoint that the run starts from
  void set_branch(const Branch& branch, std::int64_t step);
  void set_notices(std::vector<std::string> notices) { notices_ = std::move(notices); }
  void write_start();
  void write_end(ExitCode code, const std::string& reason);

 private:
  void write(const std::string& status, int code, const std::string& reason, const std::string& end);

  RunDirectory directory_;
  std::string command_line_;
  std::string build_;
  int fluid_ranks_;
  bool resumed_;
  std::string start_;
  std::string earlier_;                            ///< JSON list of the attempts before a resumed one
  std::map<std::string, std::string> components_;  ///< role to name and version
  std::string branched_from_ = "null";             ///< JSON
  std::vector<std::string> notices_;               ///< features that a component neglects, and the like
};

}  // namespace copepod::coupler
