#pragma once

#include <chrono>
#include <string_view>

#include "contract/timeline.hpp"

namespace copepod::coupler {

/// Adds up wall time over many short intervals, each of which is a phase of the timeline too.
class Stopwatch {
 public:
  using Clock = std::chrono::steady_clock;

  /// @param timeline  outlives this object
  /// @param phase     its name in the timeline; a literal
  Stopwatch(Timeline& timeline, std::string_view phase) : timeline_(timeline), phase_(phase) {}

  /// Runs `work` and adds the time it took.
  template <typename Work>
  void time(Work&& work) {
    const Clock::time_point start = Clock::now();
    work();
    const Clock::time_point end = Clock::now();
    total_ += end - start;
    timeline_.add(phase_, start, end);
  }
  [[nodiscard]] double seconds() const { return std::chrono::duration<double>(total_).count(); }

 private:
  Timeline& timeline_;
  std::string_view phase_;
  Clock::duration total_{};
};

}  // namespace copepod::coupler
