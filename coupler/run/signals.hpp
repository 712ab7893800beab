#pragma once

#include <atomic>

namespace copepod::coupler {

/// What signals have asked a run to do; each is the signal's number, 0 for none.
struct RunSignals {
  std::atomic<int> stop{0};        ///< SIGINT, SIGTERM: end as soon as possible
  std::atomic<int> checkpoint{0};  ///< SIGUSR1: write a checkpoint and go on; SIGTERM: write one, then stop
  std::atomic<bool> sigterm_waits_for_checkpoint{false};  ///< while a run can write one
};

/// Those of this process, once `watch_signals` was called.
RunSignals& process_signals();

/// SIGINT stops; SIGTERM too, after a checkpoint where one can be written; SIGUSR1 asks for a checkpoint.
/// Whoever sends a stop signal twice gets what the system does by default.
void watch_signals();

}  // namespace copepod::coupler
