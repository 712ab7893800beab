#pragma once

#include <map>
#include <string>

#include "contract/capabilities.hpp"
#include "contract/errors.hpp"
#include "run/run_directory.hpp"

namespace copepod::coupler {

/// Where the results of a run come from: provenance.json, written at the start and again at the end, so that
/// a run that was killed still says what it was.
class Provenance {
 public:
  /// @param build  identifies the programs of the run; empty: unknown
  Provenance(const RunDirectory& directory, std::string command_line, std::string build, int fluid_ranks,
             bool resumed);

  void set_components(const Capabilities& fluid, const Capabilities& body);
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
};

}  // namespace copepod::coupler
