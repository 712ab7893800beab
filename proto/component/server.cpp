#include "component/server.hpp"

#include <chrono>
#include <iostream>

namespace copepod::component {

using session::Action;
using session::Header;
using session::LocalEvent;
using session::MessageKind;
using session::Phase;
using session::State;
using session::Work;
using Clock = std::chrono::steady_clock;

namespace {

constexpr std::chrono::milliseconds kSlice{100};  ///< how soon a waiting component notices a stop request
constexpr double kRepeatHello_s = 1.0;
constexpr std::chrono::milliseconds kFarewell{500};
constexpr std::chrono::milliseconds kFarewellSlice{10};
constexpr std::chrono::milliseconds kReconnection{200};  ///< a broken connection is back before that

Phase phase_of(Work work) {
  if (work == Work::make_solver) return Phase::configuring;
  if (work == Work::write_state || work == Work::read_state) return Phase::checkpointing;
  return work == Work::confirm_end ? Phase::finishing : Phase::exchanging;
}

/// @throws Refused if the coupler requests a minor version that our Hello did not offer
void require_offered(std::uint32_t minor, const session::VersionRange& offered) {
  if (offered.minor_min <= minor && minor <= offered.minor_max) return;
  throw Refused("The coupler requests protocol " + std::to_string(offered.major) + "." + std::to_string(minor) +
                " (this component offered " + to_text(offered) + "). Build both from the same release.");
}

bool has_ended(State state) { return state == State::done || state == State::failed || state == State::orphaned; }

}  // namespace

Server::Server(transport::Dealer& dealer, ServedSolver& solver, Vitals& vitals, spdlog::logger& log,
               session::Hello hello, double connect_deadline_s)
    : dealer_(dealer),
      solver_(solver),
      vitals_(vitals),
      log_(log),
      hello_(std::move(hello)),
      connect_deadline_s_(connect_deadline_s) {
  hello_.lane = session::Lane::data;
  session_.role = solver.role();
}

ExitCode Server::run() noexcept {
  try {
    shake_hands();
    while (!has_ended(session_.state))
      if (wait_for_message(kRepeatHello_s)) handle(frame_);
    if (session_.state == State::done) stay_for_repeated_goodbyes();
  } catch (const Error& error) {
    give_up(error.code(), error.what());
  } catch (const std::exception& error) {
    give_up(ExitCode::solver_failed, error.what());
  }
  return exit_code_;
}

/// Without a connected coupler, the error is reported on standard error.
void Server::give_up(ExitCode code, const char* reason) {
  exit_code_ = code;
  log_.error("{}", reason);
  if (session_.session_id == 0) std::cerr << "error: " << reason << std::endl;
}

/// Repeats the Hello, since the coupler does not wait for it yet and would not ask again.
void Server::shake_hands() {
  const auto start = Clock::now();
  const auto deadline = start + std::chrono::duration<double>(connect_deadline_s_);
  for (std::uint32_t attempt = 0; session_.state == State::connected; ++attempt) {
    if (Clock::now() > deadline)
      throw DeadlinePassed("The coupler did not answer for " + std::to_string(static_cast<int>(connect_deadline_s_)) +
                           " s (it is not running, or at another address). Start it, or correct --endpoint.");
    if (dealer_.turned_away())
      throw Refused(
          "The coupler turned this component away (a key is missing or wrong, here or at the coupler). Give --keys "
          "with the file of this role of this run.");
    Header first = header(0);
    first.attempt = attempt;
    send(handshake_.encode(first, hello_));
    if (wait_for_message(kRepeatHello_s)) handle(frame_);
    if (session_.state == State::orphaned) return;
  }
}

/// The last reply may get lost, and the coupler may ask again; it closes the connection after receiving it. A
/// broken connection comes back at once.
void Server::stay_for_repeated_goodbyes() {
  const auto end = Clock::now() + kFarewell;
  auto last_connected = Clock::now();
  while (Clock::now() < end && Clock::now() - last_connected < kReconnection) {
    if (dealer_.receive(frame_, kFarewellSlice)) handle(frame_);
    if (dealer_.connected()) last_connected = Clock::now();
    if (dealer_.address_is_gone()) return;
  }
}

/// @return true if `frame_` holds a message; false after `seconds`, or once the process was asked to stop
bool Server::wait_for_message(double seconds) {
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  do {
    if (vitals_.context.stop_requested() != 0) {
      log_.warn("Stopping (the coupler is gone or has aborted the run).");
      session_ = on_event(session_, LocalEvent::coupler_lost).session;
      exit_code_ = static_cast<ExitCode>(vitals_.context.stop_requested());
      return false;
    }
    if (dealer_.receive(frame_, kSlice)) return true;
  } while (Clock::now() < end);
  return false;
}

void Server::handle(const transport::Frame& frame) {
  try {
    const MessageKind kind = decoder_.parse(frame.bytes());
    const session::Outcome outcome = on_message(session_, kind, decoder_.header());
    session_ = outcome.session;
    act(outcome.action);
  } catch (const conversion::DamagedMessage& damage) {
    log_.warn("Ignored a message, the coupler will send it again: {}", damage.what());
  } catch (const Error& error) {
    fail(error.code(), error.what(), error.rank(), error.step());
  } catch (const std::bad_alloc&) {
    fail(ExitCode::solver_failed, "Memory ran out (the case is too large). Use more hosts or a smaller domain.");
  } catch (const std::exception& error) {
    fail(ExitCode::solver_failed, error.what());
  }
}

void Server::act(const Action& action) {
  switch (action.kind) {
    case Action::Kind::ignore:
      return log_.warn("Ignored a {}: {}.", name_of(decoder_.kind()), action.reason);
    case Action::Kind::repeat_reply:
      return send(last_reply_);
    case Action::Kind::refuse:
      return fail(ExitCode::refused, action.reason);
    case Action::Kind::work:
      return do_work(action);
  }
}

void Server::do_work(const Action& action) {
  if (action.work == Work::accept_welcome) {
    session::Welcome welcome;
    decoder_.read(welcome);
    require_offered(welcome.minor, hello_.versions);
    session_ = welcomed(session_, welcome);
    enter(Phase::waiting);
    log_.info("Welcomed by the coupler, protocol {}.{}.", session::kProtocolMajor, welcome.minor);
    return;
  }
  if (action.work == Work::end_process) {
    session::Refusal refusal;
    decoder_.read(refusal);
    throw Refused(refusal.reason);
  }
  const bool is_of_checkpoints = action.work == Work::write_state || action.work == Work::read_state;
  const Header request = decoder_.header();
  const bool is_return = action.work == Work::make_solver && request.sequence > 1;
  const std::string needed = is_of_checkpoints ? "checkpoint" : is_return ? "snapshots" : "";
  if (!needed.empty() && !hello_.capabilities.features.contains(needed))
    throw Refused("A " + std::string(name_of(decoder_.kind())) + " was refused (this component does not announce " +
                  needed + "). Send none.");
  vitals_.received_sequence = request.sequence;
  enter(phase_of(action.work));
  vitals_.step = request.step;
  vitals_.context.timeline().set_step(request.step);
  Header reply = header(request.sequence);
  reply.step = request.step;
  const bool is_end = action.work == Work::confirm_end;
  last_reply_ = is_end ? replies_.encode(reply, MessageKind::finished)
                       : solver_.perform({action.work, decoder_, reply, replies_});
  send(last_reply_);
  vitals_.replied_sequence = request.sequence;
  if (is_end) return;
  enter(Phase::advancing);
  solver_.follow_up(action.work);
  session_ = on_event(session_, LocalEvent::work_done).session;
  enter(Phase::waiting);
}

/// Informs the control lane, and records the duration of the previous phase in the timeline.
void Server::enter(Phase phase) {
  const auto now = Timeline::Clock::now();
  vitals_.context.timeline().add(name_of(vitals_.phase.load()), phase_since_, now);
  phase_since_ = now;
  vitals_.phase = phase;
}

void Server::send(std::span<const std::byte> bytes) {
  if (!dealer_.send(bytes))
    throw ComponentLost("The coupler takes no more messages (its queue is full). Look at the coupler's log.",
                        vitals_.step.load());
}

/// Reports to the coupler and ends. An exception due to a stop request is not a failure of the solver.
void Server::fail(ExitCode code, const std::string& reason, int rank, std::int64_t step) {
  const FailureReport report{code, hello_.party(), hello_.host, rank, step >= 0 ? step : vitals_.step.load(), reason};
  const bool stopping = vitals_.context.stop_requested() != 0;
  exit_code_ = stopping ? static_cast<ExitCode>(vitals_.context.stop_requested()) : code;
  log_.error("{}", reason);
  const bool has_session = session_.state != State::connected && session_.session_id != 0;
  session_.state = State::failed;
  if (!stopping && has_session) send(handshake_.encode(header(0), report));
}

}  // namespace copepod::component
