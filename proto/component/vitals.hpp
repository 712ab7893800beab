#pragma once

#include <atomic>
#include <cstdint>

#include "component/progress.hpp"
#include "session/messages.hpp"

namespace copepod::component {

/// What the solver's thread lets the control lane know, so that pings are answered while it computes.
struct Vitals {
  std::atomic<std::int64_t> step{-1};
  std::atomic<session::Phase> phase{session::Phase::greeting};
  std::atomic<std::uint64_t> received_sequence{0};
  std::atomic<std::uint64_t> replied_sequence{0};

  [[nodiscard]] session::Pong pong(const session::Ping& ping) const {
    return {ping.stamp_ns,
            step.load(),
            phase.load(),
            progress_counter().load(),
            received_sequence.load(),
            replied_sequence.load(),
            awaited_rank().load()};
  }
};

}  // namespace copepod::component
