#pragma once

#include <atomic>

namespace copepod::coupler {

/// What signals have asked a run to do; each is the signal's number, 0 for none.
struct RunSignals {
  std::atomic<int> stop{0};        ///< end as soon as possible
  std::atomic<int> checkpoint{0};  ///< SIGUSR1: write one and continue; any other: write one, then stop
  std::atomic<bool> stop_waits_for_checkpoint{false};  ///< while a run can write one
};

/// Hands this process's signals to one run: SIGINT, SIGTERM and SIGHUP (unless it was ignored) stop, after a checkpoint
/// where one can be written; SIGUSR1 asks for a checkpoint. The second signal to stop does not wait for the checkpoint,
/// the third has its default effect. One at a time; the handlers reach it through the only mutable global of the
/// coupler [docs/decisions/process_wide_state.md].
class SignalWatch {
 public:
  /// @param signals  must outlive this object
  explicit SignalWatch(RunSignals& signals);
  SignalWatch(const SignalWatch&) = delete;
  SignalWatch& operator=(const SignalWatch&) = delete;
  ~SignalWatch();
};

}  // namespace copepod::coupler
