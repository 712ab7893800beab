#pragma once

#include <algorithm>
#include <chrono>
#include <sched.h>

#include "transport/frame.hpp"

namespace copepod::transport {

/// How a lane waits for its next message: all lanes sleep at once, another way is there for the measurement
/// that says why (docs/decisions: "How the data lanes wait").
struct WaitPolicy {
  Duration yield_for{
      0};  ///< first try again and again, giving the core away in between; then sleep in the kernel
};

/// Of the lanes that the exchange of every step goes through.
inline constexpr WaitPolicy kDataLanePolicy{};

/// Tries until something is there or the time for trying is over.
/// @param attempt  returns true when it got something
template <class Attempt>
bool try_for_a_while(const WaitPolicy& policy, Duration wait, Attempt attempt) {
  using Clock = std::chrono::steady_clock;
  if (attempt()) return true;
  const Duration limit = std::min(policy.yield_for, wait);
  if (limit <= Duration::zero()) return false;
  const auto end = Clock::now() + limit;
  while (Clock::now() < end) {
    sched_yield();
    if (attempt()) return true;
  }
  return false;
}

}  // namespace copepod::transport
