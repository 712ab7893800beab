#pragma once

#include <atomic>

namespace copepod {

/// Process-wide flag: non-zero when the coupler is gone or has aborted the run; the value is the exit code to
/// end with.
///
/// A solver in a long loop may look at it and throw; a process that does not end within 2 s is ended.
inline std::atomic<int>& stop_request() {
  static std::atomic<int> exit_code{0};
  return exit_code;
}

}  // namespace copepod
