#pragma once

namespace copepod {

/// Exit codes of every Copepod process and of `deploy/copepod`.
enum class ExitCode : int {
  finished = 0,
  bad_case = 2,          ///< bad case file or command line
  refused = 65,          ///< refused by the peer: version, role, key, capability
  component_lost = 69,   ///< a component died, froze or hung
  solver_failed = 70,    ///< diverged, NaN
  storage_failed = 73,   ///< output or checkpoint could not be written or read
  deadline_passed = 74,  ///< no answer came in time
  interrupted = 130,     ///< SIGINT
  terminated = 143,      ///< SIGTERM
};

}  // namespace copepod
