#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>

#include "checkpoint/checkpoint_store.hpp"
#include "config/sections/case.hpp"
#include "observers/events.hpp"
#include "run/components.hpp"

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

/// Which steps enter the mean field that a case asks for.
inline MeanSampling mean_sampling(const OutputCase& output) {
  return {output.fields.mean_start, output.fields.mean_every_steps};
}

/// Decides when a checkpoint is due: every so many steps, and every so many seconds of wall time.
class CheckpointSchedule {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param every_steps   0: not by steps
  /// @param every_wall_s  0: not by time
  /// @param first_step    where the run begins; nothing is due there
  CheckpointSchedule(std::int64_t every_steps, double every_wall_s, std::int64_t first_step, Clock::time_point now)
      : every_steps_(every_steps), every_wall_(every_wall_s), last_step_(first_step), last_time_(now) {}

  [[nodiscard]] bool due(std::int64_t step, Clock::time_point now) const {
    if (step == last_step_) return false;
    const bool by_steps = every_steps_ > 0 && step % every_steps_ == 0;
    const bool by_time = every_wall_.count() > 0.0 && now - last_time_ >= every_wall_;
    return by_steps || by_time;
  }

  /// Also after an attempt that failed: the next one comes when it would have come anyway.
  void written(std::int64_t step, Clock::time_point now) {
    last_step_ = step;
    last_time_ = now;
  }

 private:
  std::int64_t every_steps_;
  std::chrono::duration<double> every_wall_;
  std::int64_t last_step_;
  Clock::time_point last_time_;
};

/// Interrupts a run where a checkpoint is due or a signal came, and writes checkpoints.
class Checkpointer {
 public:
  /// References must outlive this object.
  /// @param able  whether all components can save; if not, signals only stop
  enum class Ability { none, saves };
  Checkpointer(const CheckpointStore& store, Components& components, Ability able, const Case& the_case,
               std::int64_t first_step, RunSignals& signals, Events& events);
  Checkpointer(const Checkpointer&) = delete;
  Checkpointer& operator=(const Checkpointer&) = delete;
  ~Checkpointer() { signals_.stop_waits_for_checkpoint.store(false); }

  /// Whether the run should pause before `step`; never before the first one, where there is nothing to save.
  /// @throws Interrupted if a signal asked the run to end now
  bool wants_pause(std::int64_t step);

  /// Writes a checkpoint of the pausing run. A disk that does not take it is reported, and the run continues.
  /// @param step   that comes next
  /// @param state  returns the coupler's own part
  /// @throws Interrupted after it, if SIGTERM asked for it; what the solvers throw
  void write(const SolversByFile& solvers, std::int64_t step, const std::function<CouplerState()>& state);

 private:
  void commit(const SolversByFile& solvers, const std::function<CouplerState()>& state);

  CheckpointStore store_;
  Components& components_;
  Ability able_;
  std::int64_t first_step_;
  CheckpointSchedule schedule_;
  std::uintmax_t expected_bytes_;  ///< of the first checkpoint
  RunSignals& signals_;
  Events& events_;
};

}  // namespace copepod::coupler
