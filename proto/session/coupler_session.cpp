#include "session/coupler_session.hpp"

#include <algorithm>
#include <cmath>

#include "session/component_session.hpp"

namespace copepod::session {

namespace {

/// The step that the answer to the open request must carry.
std::int64_t due_step(const CouplerSession& session) {
  return session.request == MessageKind::applied_loads ? session.step + 1 : session.step;
}

/// Whether a message belongs to no request so far, or is the due result of a step under the number of an
/// older request. Other replies with an older number are repetitions.
bool has_wrong_sequence(const CouplerSession& session, MessageKind kind, const Header& header) {
  if (header.sequence == 0 || header.sequence > session.sequence) return true;
  const bool is_result = kind == MessageKind::loads || kind == MessageKind::kinematics || kind == MessageKind::action;
  return session.waits() && header.sequence != session.sequence && is_result && kind == session.expected_reply &&
         header.step == due_step(session);
}

/// "Loads of step 4"
std::string text_of(MessageKind kind, std::int64_t step) {
  return std::string(name_of(kind)) + " of step " + std::to_string(step);
}

}  // namespace

bool same_token(const std::string& a, const std::string& b) {
  unsigned difference = a.size() == b.size() ? 0U : 1U;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
    difference |= static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i]);
  return difference == 0;
}

bool is_entitled(const std::string& identity, const std::string& party) {
  return identity.empty() || identity == party;
}

HelloVerdict judge_hello(const Hello& hello, const HelloExpectation& expectation) {
  const std::string role = hello.party();
  const auto refused = [&](const std::string& why, bool is_stranger) -> HelloVerdict {
    return {std::nullopt, "The " + role + " component on " + hello.host + " was refused " + why, is_stranger};
  };
  if (!same_token(hello.session_token, expectation.session_token))
    return refused("(its session token is not that of this run). Start it with the --session of this run.", true);
  if (!is_entitled(expectation.identity, role))
    return refused(
        "(it holds the key of the " + expectation.identity + " component). Give it the key file of its own role.",
        false);
  const auto minor = negotiate(expectation.versions, hello.versions);
  if (!minor) {
    const bool is_older = hello.versions.major < expectation.versions.major;
    return refused("(it supports protocol " + to_text(hello.versions) + ", the coupler " +
                       to_text(expectation.versions) + "). " +
                       (is_older ? "Build it with the kit of this release: docs/moving_to_a_newer_kit.md."
                                 : "Build both from the same release."),
                   false);
  }
  if (!expectation.is_wanted)
    return refused("(the case has no controller of that name). Start it with the --name of one.", true);
  if (expectation.role_taken)
    return refused("(a " + role + " component already takes part). Start one component per role.", true);
  return {minor, {}, false};
}

CouplerSession welcomed(CouplerSession session, std::uint64_t session_id, std::uint64_t epoch) {
  session.state = State::greeted;
  session.session_id = session_id;
  session.epoch = epoch;
  return session;
}

Asked ask(const CouplerSession& session, MessageKind request, std::int64_t step) {
  const std::string who = std::string(name_of(session.role)) + " component";
  if (session.waits())
    return {session, "The " + who + " was asked for " + std::string(name_of(request)) + " too early (it has not " +
                         "answered " + std::string(name_of(session.request)) + " yet). Wait for the reply."};
  const Transition* transition = find_transition(session.role, session.state, request);
  if (transition == nullptr)
    return {session, std::string(name_of(request)) + " cannot be sent to the " + who + " (in state '" +
                         std::string(name_of(session.state)) + "' it allows " +
                         legal_messages(session.role, session.state) + "). Call in the order of the contract."};
  CouplerSession next = session;
  next.sequence = session.sequence + 1;
  next.attempt = 0;
  next.step = step;
  next.request = request;
  next.expected_reply = transition->reply;
  next.follows_up = false;
  return {next, {}};
}

CouplerSession ask_again(CouplerSession session) {
  ++session.attempt;
  return session;
}

Heard hear(const CouplerSession& session, MessageKind kind, const Header& header) {
  const auto refused = [&](const std::string& what) -> Heard { return {session, Heard::Kind::refuse, what}; };
  if (header.session_id != session.session_id || header.epoch != session.epoch)
    return {session, Heard::Kind::stale, {}};
  if (kind == MessageKind::failure) {
    CouplerSession failed = session;
    failed.state = State::failed;
    failed.request = MessageKind::none;
    return {failed, Heard::Kind::failure, {}};
  }
  if (has_wrong_sequence(session, kind, header))
    return refused("it sent " + text_of(kind, header.step) + " with sequence number " +
                   std::to_string(header.sequence) + ", that of the request is " + std::to_string(session.sequence));
  if (!session.waits() || header.sequence != session.sequence) return {session, Heard::Kind::stale, {}};
  if (kind != session.expected_reply)
    return refused("it answered " + std::string(name_of(session.request)) + " with " + std::string(name_of(kind)) +
                   ", " + std::string(name_of(session.expected_reply)) + " was due");
  if (header.step != due_step(session))
    return refused("it answered " + text_of(session.request, session.step) + " with " + text_of(kind, header.step) +
                   ", step " + std::to_string(due_step(session)) + " was due");
  CouplerSession next = session;
  next.state = next_state(*find_transition(session.role, session.state, session.request), session.state);
  const bool busy = next.state == State::stepping || next.state == State::checkpointing;
  if (busy) next.state = State::ready;  // the next request may be sent at once: the component queues it
  next.request = MessageKind::none;
  next.expected_reply = MessageKind::none;
  next.follows_up = kind == MessageKind::loads;
  return {next, Heard::Kind::reply, {}};
}

Header header_of(const CouplerSession& session) {
  return {.session_id = session.session_id,
          .epoch = session.epoch,
          .sequence = session.sequence,
          .attempt = session.attempt,
          .step = session.step};
}

Liveness on_ping(Liveness liveness, const Patience& patience, double now_s) {
  liveness.last_ping_s = now_s;
  liveness.ping_interval_s = std::min(2 * liveness.ping_interval_s, patience.ping_every_s);
  liveness.next_ping_s = now_s + liveness.ping_interval_s;
  if (liveness.unanswered_since_s < 0) liveness.unanswered_since_s = now_s;
  return liveness;
}

Liveness on_pong(Liveness liveness, const Pong& pong, const Patience& patience, double now_s) {
  const Pong& before = liveness.pong;
  if (pong.stamp_ns < before.stamp_ns) return liveness;
  const bool moved = pong.step != before.step || pong.phase != before.phase || pong.progress != before.progress ||
                     pong.received_sequence != before.received_sequence ||
                     pong.replied_sequence != before.replied_sequence;
  const double silent_s = liveness.unanswered_since_s < 0 ? 0.0 : now_s - liveness.unanswered_since_s;
  if (silent_s > patience.pause_s) liveness.last_change_s += silent_s;  // in which nothing could be seen to move
  if (moved) liveness.last_change_s = now_s;
  liveness.pong = pong;
  liveness.unanswered_since_s = -1;
  return liveness;
}

Liveness on_request(Liveness liveness, const Patience& patience, double resend_after_s, double now_s) {
  liveness.last_change_s = now_s;
  liveness.ping_interval_s = resend_after_s;
  liveness.next_ping_s = std::min(liveness.last_ping_s + patience.ping_every_s, now_s + resend_after_s);
  return liveness;
}

Liveness on_look(Liveness liveness, bool connected, const Patience& patience, double now_s) {
  const bool was_away = now_s - liveness.attention_s > patience.pause_s;
  if (was_away) {
    liveness.last_change_s = now_s;
    if (liveness.unanswered_since_s >= 0) liveness.unanswered_since_s = now_s;
    if (liveness.disconnected_since_s >= 0) liveness.disconnected_since_s = now_s;
  }
  liveness.attention_s = now_s;
  if (connected) liveness.disconnected_since_s = -1;
  if (!connected && liveness.disconnected_since_s < 0) liveness.disconnected_since_s = now_s;
  return liveness;
}

Health judge(const Liveness& liveness, bool work_due, const Patience& patience, double now_s) {
  const bool disconnected = liveness.disconnected_since_s >= 0;
  if (disconnected && now_s - liveness.disconnected_since_s > patience.disconnected_s) return Health::disconnected;
  const bool unanswered = liveness.unanswered_since_s >= 0;
  if (unanswered && now_s - liveness.unanswered_since_s > patience.silence_s) return Health::silent;
  const bool busy = work_due || liveness.pong.phase != Phase::waiting;
  const double seen_s = unanswered ? liveness.unanswered_since_s : now_s;
  if (busy && seen_s - liveness.last_change_s > patience.progress_deadline_s) return Health::hung;
  return Health::fine;
}

double resend_after_s(const Patience& patience, std::size_t message_bytes, std::uint32_t attempt) {
  constexpr std::uint32_t most_doublings = 8;
  const double transfer_s = static_cast<double>(message_bytes) / patience.slowest_bytes_per_s;
  return (patience.resend_s + transfer_s) * static_cast<double>(1U << std::min(attempt, most_doublings));
}

bool was_lost(const Liveness& liveness, std::uint64_t sequence, double sent_s, double after_s) {
  const double asked_s = 1e-9 * static_cast<double>(liveness.pong.stamp_ns);
  if (asked_s - sent_s < after_s) return false;
  const bool request_lost = liveness.pong.phase == Phase::waiting && liveness.pong.received_sequence < sequence;
  const bool reply_lost = liveness.pong.replied_sequence >= sequence;
  return request_lost || reply_lost;
}

bool ping_is_due(const Liveness& liveness, const Patience& patience, double now_s) {
  const bool broken = liveness.disconnected_since_s >= 0;
  return now_s >= liveness.next_ping_s || (broken && now_s >= liveness.last_ping_s + patience.ping_broken_s);
}

std::string describe(Health health, const Liveness& liveness, double now_s) {
  const auto seconds_since = [now_s](double then_s) { return std::to_string(std::lround(now_s - then_s)) + " s"; };
  switch (health) {
    case Health::fine:
      return "is fine";
    case Health::disconnected:
      return "is gone (its connection broke and did not come back: the process died or was killed)";
    case Health::silent:
      return "is frozen (no answer to a ping for " + seconds_since(liveness.unanswered_since_s) +
             ": the process is suspended or its host unreachable)";
    case Health::hung:
      return "hangs (it answers pings but has been " + std::string(name_of(liveness.pong.phase)) +
             " without progress for " + seconds_since(liveness.last_change_s) + ")";
  }
  return "is in an unknown condition";
}

}  // namespace copepod::session
