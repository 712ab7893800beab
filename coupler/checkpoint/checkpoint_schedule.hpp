#pragma once

#include <chrono>
#include <cstdint>

namespace copepod::coupler {

/// Decides when a checkpoint is due: every so many steps, and every so many seconds of wall time.
class CheckpointSchedule {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param every_steps   0: not by steps
  /// @param every_wall_s  0: not by time
  /// @param first_step    where the run begins; nothing is due there
  CheckpointSchedule(std::int64_t every_steps, double every_wall_s, std::int64_t first_step,
                     Clock::time_point now)
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

}  // namespace copepod::coupler
