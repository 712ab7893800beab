#pragma once

#include <algorithm>
#include <ctime>
#include <sched.h>

namespace copepod::fluid {

/// Pauses between two polls of a wait: yields at first, then sleeps ever longer.
///
/// A message that comes within `spin_s` is seen at once; afterwards the pause is an eighth of the time waited
/// so far, so it adds at most that share to the wait, up to `longest_pause_s`.
/// docs/decisions/waiting_ranks_sleep.md has the measurement behind the figures.
class Backoff {
 public:
  static constexpr double spin_s = 100e-6;
  static constexpr double longest_pause_s = 1e-3;

  Backoff() : start_s_(now_s()) {}

  void pause() const {
    const double waited_s = now_s() - start_s_;
    if (waited_s < spin_s) {
      sched_yield();
      return;
    }
    const double pause_s = std::min(waited_s / 8, longest_pause_s);
    const timespec duration{0, static_cast<long>(pause_s * 1e9)};
    nanosleep(&duration, nullptr);
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
