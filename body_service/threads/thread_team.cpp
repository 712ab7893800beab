#include "threads/thread_team.hpp"

#include <string>
#include <system_error>
#include <utility>

#include "contract/errors.hpp"
#include "system/process.hpp"

namespace copepod::body {

ThreadTeam::ThreadTeam(int threads) {
  others_.reserve(threads - 1);
  try {
    for (int thread = 1; thread < threads; ++thread)
      others_.emplace_back([this, thread](const std::stop_token& stop) { wait_for_loops(stop, thread); });
  } catch (const std::system_error& error) {
    throw SolverError("thread " + std::to_string(others_.size() + 2) + " of " + std::to_string(threads) +
                      " cannot be started (" + error.code().message() + "). Use a smaller services.body.threads.");
  }
}

void ThreadTeam::take(const Loop& loop) {
  if (others_.empty() || loop.parts <= 1) {
    for (std::int64_t part = 0; part < loop.parts; ++part) loop.call(loop.work, part, 0);
    return;
  }
  std::unique_lock lock(mutex_);
  loop_ = loop;
  next_part_ = 0;
  loop_begins_.notify_all();
  take_parts(0, lock);
  part_ends_.wait(lock, [this] { return at_work_ == 0; });
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void ThreadTeam::take_parts(int thread, std::unique_lock<std::mutex>& lock) {
  while (next_part_ < loop_.parts) {
    const std::int64_t part = next_part_++;
    ++at_work_;
    lock.unlock();
    std::exception_ptr error;
    try {
      loop_.call(loop_.work, part, thread);
    } catch (...) {
      error = std::current_exception();
    }
    lock.lock();
    --at_work_;
    if (!error) continue;
    // Lower parts have all been handed out: the lowest error is known when they are done.
    if (!error_ || part < part_of_error_) {
      error_ = error;
      part_of_error_ = part;
    }
    next_part_ = loop_.parts;
  }
  if (at_work_ == 0) part_ends_.notify_one();
}

void ThreadTeam::wait_for_loops(const std::stop_token& stop, int thread) {
  block_signals();
  std::unique_lock lock(mutex_);
  while (loop_begins_.wait(lock, stop, [this] { return next_part_ < loop_.parts; })) take_parts(thread, lock);
}

}  // namespace copepod::body
