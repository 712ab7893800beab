#pragma once

#include <chrono>

namespace copepod::coupler {

/// Adds up wall time over many short intervals.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// Runs `work` and adds the time it took.
  template <typename Work>
  void time(Work&& work) {
    const Clock::time_point start = Clock::now();
    work();
    total_ += Clock::now() - start;
  }
  [[nodiscard]] double seconds() const { return std::chrono::duration<double>(total_).count(); }

 private:
  Clock::duration total_{};
};

}  // namespace copepod::coupler
