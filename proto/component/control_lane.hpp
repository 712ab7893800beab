#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>

#include <spdlog/logger.h>

#include "contract/solver_context.hpp"
#include "session/component_session.hpp"
#include "session/messages.hpp"
#include "transport/lanes.hpp"

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

/// A thread that answers the coupler's pings and its Abort, also while the solver computes, and that notices
/// when the coupler is gone. It never touches the solver or MPI: it requests a stop from the SolverContext,
/// and if the solver's thread has not ended the process 2 s later, it does so itself.
class ControlLane {
 public:
  /// Starts the thread.
  /// @param hello  to send; its lane is set here
  /// @param vitals  outlives this object, as does `log`
  ControlLane(std::unique_ptr<transport::Dealer> dealer, const Vitals& vitals, spdlog::logger& log,
              session::Hello hello, session::OrphanPatience patience);

  /// Ends the thread; the process will end by itself.
  ~ControlLane();

 private:
  std::atomic<bool> leaving_{false};
  std::thread thread_;
};

}  // namespace copepod::component
