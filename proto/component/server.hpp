#pragma once

#include <spdlog/logger.h>

#include "component/control_lane.hpp"
#include "component/served_solver.hpp"
#include "contract/errors.hpp"
#include "session/component_session.hpp"
#include "session/messages.hpp"
#include "transport/lanes.hpp"

namespace copepod::component {

/// The data lane of a component: sends Hello, then answers requests until the run ends. Messages that were
/// damaged on their way count as lost.
///
/// The session table decides what a message means; this class does what it decides. Single-threaded: a
/// request that arrives during a bulk update waits in the transport's queue.
class Server {
 public:
  /// @param hello  to send; its lane is set here
  /// All references outlive the server.
  Server(transport::Dealer& dealer, ServedSolver& solver, Vitals& vitals, spdlog::logger& log, session::Hello hello,
         double connect_deadline_s);

  /// @return how the process should end; never throws
  ExitCode run() noexcept;

 private:
  void shake_hands();
  void serve();
  void stay_for_repeated_goodbyes();
  void handle(const transport::Frame& frame);
  void act(const session::Action& action);
  void do_work(const session::Action& action);
  bool wait_for_message(double seconds);
  void enter(session::Phase phase);
  void send(std::span<const std::byte> bytes);
  void give_up(ExitCode code, const char* reason);
  void fail(const FailureReport& report);
  [[nodiscard]] FailureReport report(ExitCode code, const std::string& reason, int rank, std::int64_t step) const;
  [[nodiscard]] session::Header header(std::uint64_t sequence) const {
    return {.session_id = session_.session_id, .epoch = session_.epoch, .sequence = sequence};
  }

  transport::Dealer& dealer_;
  ServedSolver& solver_;
  Vitals& vitals_;
  spdlog::logger& log_;
  session::Hello hello_;
  double connect_deadline_s_;

  session::ComponentSession session_;
  transport::Frame frame_;
  conversion::Decoder decoder_;
  conversion::Encoder replies_;  ///< keeps the bytes of the last reply for a request that is repeated
  conversion::Encoder handshake_;
  std::span<const std::byte> last_reply_;
  Timeline::Clock::time_point phase_since_ = Timeline::Clock::now();
  ExitCode exit_code_ = ExitCode::finished;
};

}  // namespace copepod::component
