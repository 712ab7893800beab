#pragma once

#include <algorithm>
#include <ctime>
#include <sched.h>

namespace copepod::fluid {

/// Pauses between two polls of a wait: yields at first, then sleeps ever longer.
///
/// docs/decisions/waiting_ranks_sleep.md has the measurement behind the figures.
class Backoff {
 public:
  static constexpr double spin_s = 100e-6;
  static constexpr double longest_pause_s = 1e-3;

  Backoff() : start_s_(now_s()) {}

  /// Sleep after a wait, 0 to yield: a message that comes within `spin_s` is seen at once; later the sleep adds
  /// at most an eighth to the wait.
  static constexpr double pause_s(double waited_s) {
    return waited_s < spin_s ? 0.0 : std::min(waited_s / 8, longest_pause_s);
  }

  void pause() const {
    const double sleep_s = pause_s(waited_s());
    const timespec duration{0, static_cast<long>(sleep_s * 1e9)};
    if (sleep_s > 0.0) {
      nanosleep(&duration, nullptr);
    } else {
      sched_yield();
    }
  }

  [[nodiscard]] double waited_s() const { return now_s() - start_s_; }

 private:
  static double now_s() {
    timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  double start_s_;
};

}  // namespace copepod::fluid
