#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

namespace copepod::body {

/// Threads that share the parts of a loop with the thread that owns them; between loops they sleep.
///
/// Parts are handed out one by one, in ascending order, to whichever thread is free. A thread that the operating system
/// does not run holds up no other, and a loop does not wait for threads that have yet to wake up.
class ThreadTeam {
 public:
  /// @param threads  the owner included, ≥ 1
  /// @throws SolverError if they cannot be started
  explicit ThreadTeam(int threads);

  /// Calls `work(part, thread)` for every part in [0, parts) and returns when all are done.
  /// @param work  must not depend on the order of the parts; `thread` in [0, threads) is the number of the caller
  /// @throws what the lowest part of those that throw does, as a loop over the parts would
  template <class Work>
  void share(std::int64_t parts, const Work& work) {
    take({parts, [](const void* it, std::int64_t part, int thread) { (*static_cast<const Work*>(it))(part, thread); },
          &work});
  }

 private:
  struct Loop {
    std::int64_t parts = 0;
    void (*call)(const void* work, std::int64_t part, int thread) = nullptr;
    const void* work = nullptr;
  };

  void take(const Loop& loop);
  void take_parts(int thread, std::unique_lock<std::mutex>& lock);
  void wait_for_loops(const std::stop_token& stop, int thread);

  std::mutex mutex_;  ///< of what follows
  std::condition_variable_any loop_begins_;
  std::condition_variable part_ends_;
  Loop loop_;
  std::int64_t next_part_ = 0;
  int at_work_ = 0;  ///< threads that do a part
  std::exception_ptr error_;
  std::int64_t part_of_error_ = 0;

  std::vector<std::jthread> others_;  ///< last: they end before what they use
};

}  // namespace copepod::body
