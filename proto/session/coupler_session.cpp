#include "session/coupler_session.hpp"

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
  const bool is_result = kind == MessageKind::loads || kind == MessageKind::kinematics;
  return session.waits() && header.sequence != session.sequence && is_result && kind == session.expected_reply &&
         header.step == due_step(session);
}

/// "Loads of step 4"
std::string text_of(MessageKind kind, std::int64_t step) {
  return std::string(name_of(kind)) + " of step " + std::to_string(step);
}

}  // namespace

CouplerSession welcomed(CouplerSession session, std::uint64_t session_id, std::uint64_t epoch) {
  session.state = State::greeted;
  session.session_id = session_id;
  session.epoch = epoch;
  return session;
}

Asked ask(const CouplerSession& session, MessageKind request, std::int64_t step) {
  const std::string who = std::string(name_of(session.role)) + " component";
  if (session.waits()) {
    return {session, "The " + who + " was asked for " + std::string(name_of(request)) + " too early (it has not " +
                         "answered " + std::string(name_of(session.request)) + " yet). Wait for the reply."};
  }
  const Transition* transition = find_transition(session.role, session.state, request);
  if (transition == nullptr) {
    return {session, std::string(name_of(request)) + " cannot be sent to the " + who + " (in state '" +
                         std::string(name_of(session.state)) + "' it allows " +
                         legal_messages(session.role, session.state) + "). Call in the order of the contract."};
  }
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
  if (header.session_id != session.session_id || header.epoch != session.epoch) {
    return {session, Heard::Kind::stale, {}};
  }
  if (kind == MessageKind::failure) {
    CouplerSession failed = session;
    failed.state = State::failed;
    failed.request = MessageKind::none;
    return {failed, Heard::Kind::failure, {}};
  }
  if (has_wrong_sequence(session, kind, header)) {
    return {session, Heard::Kind::refuse,
            "it sent " + text_of(kind, header.step) + " with sequence number " + std::to_string(header.sequence) +
                ", that of the request is " + std::to_string(session.sequence)};
  }
  if (!session.waits() || header.sequence != session.sequence) return {session, Heard::Kind::stale, {}};
  if (kind != session.expected_reply) {
    return {session, Heard::Kind::refuse,
            "it answered " + std::string(name_of(session.request)) + " with " + std::string(name_of(kind)) + ", " +
                std::string(name_of(session.expected_reply)) + " was due"};
  }
  if (header.step != due_step(session)) {
    return {session, Heard::Kind::refuse,
            "it answered " + text_of(session.request, session.step) + " with " + text_of(kind, header.step) +
                ", step " + std::to_string(due_step(session)) + " was due"};
  }
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
  Header header;
  header.session_id = session.session_id;
  header.epoch = session.epoch;
  header.sequence = session.sequence;
  header.attempt = session.attempt;
  header.step = session.step;
  return header;
}

}  // namespace copepod::session
