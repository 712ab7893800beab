#pragma once

#include <atomic>
#include <cstdint>

namespace copepod {

/// Process-wide counter that long computations may increase to show that they are alive.
///
/// The coupler takes a component whose step, phase and progress counter all stand still for
/// `progress_deadline_s` for hung. A solver whose step or setup can take that long increases the counter now
/// and then; others need not care.
inline std::atomic<std::uint64_t>& progress_counter() {
  static std::atomic<std::uint64_t> counter{0};
  return counter;
}

/// Shows that the computation moves on; costs one relaxed atomic addition.
inline void report_progress() { progress_counter().fetch_add(1, std::memory_order_relaxed); }

/// Process-wide: which process of a parallel component the others wait for, so that the coupler can name it
/// should it hang; 0 as long as nobody waits for long.
inline std::atomic<int>& awaited_rank() {
  static std::atomic<int> rank{0};
  return rank;
}

}  // namespace copepod
