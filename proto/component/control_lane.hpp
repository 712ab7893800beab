#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include <spdlog/logger.h>

#include "component/vitals.hpp"
#include "session/messages.hpp"
#include "session/orphanhood.hpp"
#include "transport/dealer.hpp"

namespace copepod::component {

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
  ControlLane(const ControlLane&) = delete;
  ControlLane& operator=(const ControlLane&) = delete;

  /// Ends the thread; the process will end by itself.
  ~ControlLane();

 private:
  std::atomic<bool> leaving_{false};
  std::thread thread_;
};

}  // namespace copepod::component
