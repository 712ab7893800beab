#pragma once

#include <atomic>
#include <cstdint>

#include "contract/timeline.hpp"

namespace copepod {

/// What a solver and the process that serves it share, beside the calls of the solver. One per solver; all
/// methods but those of the timeline may be called from any thread.
class SolverContext {
 public:
  /// Shows that a long computation advances; costs one relaxed atomic addition.
  ///
  /// The coupler takes a component whose step, phase and progress all stand still for `progress_deadline_s`
  /// for hung. Call this now and then from a step or setup that can take that long.
  void report_progress() { progress_.fetch_add(1, std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t progress() const { return progress_.load(std::memory_order_relaxed); }  ///< times

  /// Not 0 when the coupler is gone or has aborted the run: the exit code to end with. A solver in a long
  /// loop may check it and throw; a process that does not end within 2 s is ended.
  [[nodiscard]] int stop_requested() const { return stop_; }
  /// Only the first request counts.
  void request_stop(int exit_code) {
    int none = 0;
    stop_.compare_exchange_strong(none, exit_code);
  }

  /// Which process of a parallel component the others wait for, so that the coupler can name it if it hangs;
  /// 0 as long as no wait takes long.
  void await_rank(int rank) { awaited_rank_ = rank; }
  [[nodiscard]] int awaited_rank() const { return awaited_rank_; }  ///< as `await_rank` named it last

  /// Of the solver's thread.
  [[nodiscard]] Timeline& timeline() { return timeline_; }

 private:
  std::atomic<std::uint64_t> progress_{0};
  std::atomic<int> stop_{0};
  std::atomic<int> awaited_rank_{0};
  Timeline timeline_;
};

}  // namespace copepod
