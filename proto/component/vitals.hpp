#pragma once

#include <atomic>
#include <cstdint>

#include "contract/solver_context.hpp"
#include "session/messages.hpp"

namespace copepod::component {

/// State of the solver's thread that the control lane reads, so that pings are answered while it computes.
struct Vitals {
  explicit Vitals(SolverContext& solver_context) : context(solver_context) {}

  SolverContext& context;
  std::atomic<std::int64_t> step{-1};
  std::atomic<session::Phase> phase{session::Phase::connecting};
  std::atomic<std::uint64_t> received_sequence{0};
  std::atomic<std::uint64_t> replied_sequence{0};

  [[nodiscard]] session::Pong pong(const session::Ping& ping) const {
    return {ping.stamp_ns,           step.load(),           phase.load(), context.progress(), received_sequence.load(),
            replied_sequence.load(), context.awaited_rank()};
  }
};

}  // namespace copepod::component
