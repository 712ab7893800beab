#include "session/component_session.hpp"

#include <vector>

#include "contract/words.hpp"

namespace copepod::session {

namespace {

using Kind = Action::Kind;

Outcome refuse(ComponentSession session, const std::string& reason) {
  session.state = State::failed;
  return {session, {Kind::refuse, Work::none, MessageKind::failure, reason}};
}

Outcome ignore(const ComponentSession& session, const std::string& reason) {
  return {session, {Kind::ignore, Work::none, MessageKind::none, reason}};
}

Outcome take(ComponentSession session, const Transition& transition) {
  session.state = next_state(transition, session.state);
  return {session, {Kind::work, transition.work, transition.reply, {}}};
}

/// Messages that advance a simulation by one step.
bool is_step(Work work) { return work == Work::compute_loads || work == Work::advance_bodies; }

std::string illegal(const ComponentSession& session, MessageKind kind) {
  return std::string(name_of(kind)) + " is not allowed now (a " + std::string(name_of(session.role)) +
         " component in state '" + std::string(name_of(session.state)) + "' allows " +
         legal_messages(session.role, session.state) + "). Send the messages in the order of docs/protocol.md.";
}

Outcome on_request(ComponentSession session, MessageKind kind, const Header& header) {
  if (header.sequence == 0)
    return refuse(session, std::string(name_of(kind)) +
                               " came without a number (its sequence is 0). Number the requests from 1.");
  if (header.sequence == session.last_sequence) return {session, {Kind::repeat_reply, {}, {}, {}}};
  if (header.sequence < session.last_sequence)
    return ignore(session, "request " + std::to_string(header.sequence) + " was answered long ago");
  const Transition* transition = find_transition(session.role, session.state, kind);
  if (transition == nullptr) return refuse(session, illegal(session, kind));
  if (header.sequence != session.last_sequence + 1)
    return refuse(session, "request " + std::to_string(header.sequence) + " came after request " +
                               std::to_string(session.last_sequence) +
                               " (one in between was lost). Send every request until it is answered.");
  if (is_step(transition->work) && header.step != session.next_step)
    return refuse(session, std::string(name_of(kind)) + " of step " + std::to_string(header.step) +
                               " came where step " + std::to_string(session.next_step) +
                               " was due (a step was left out or done twice). Advance step by step.");
  if (transition->work == Work::decide && header.step < session.next_step)
    return refuse(session, "An Observation of step " + std::to_string(header.step) + " came after that of step " +
                               std::to_string(session.next_step - 1) + " (time runs forward). Send them in order.");
  const bool sets_step = transition->work == Work::make_solver || transition->work == Work::read_state;
  if (sets_step || transition->work == Work::decide) session.next_step = header.step;
  session.last_sequence = header.sequence;
  return take(session, *transition);
}

}  // namespace

Outcome on_message(const ComponentSession& session, MessageKind kind, const Header& header) {
  const bool in_handshake = kind == MessageKind::welcome || kind == MessageKind::refusal;
  if (in_handshake) {
    if (session.state != State::connected) return ignore(session, "the handshake is over");
    return take(session, *find_transition(session.role, session.state, kind));
  }
  if (session.state == State::connected) return ignore(session, "the Welcome has not come yet");
  if (header.session_id != session.session_id || header.epoch != session.epoch)
    return ignore(session, "message of another session or of an earlier coupler");
  return on_request(session, kind, header);
}

Outcome on_event(const ComponentSession& session, LocalEvent event) {
  const Transition* transition = find_transition(session.role, session.state, event);
  if (transition == nullptr) return ignore(session, "nothing is left to do");
  Outcome outcome = take(session, *transition);
  if (event == LocalEvent::work_done && session.state == State::stepping) ++outcome.session.next_step;
  return outcome;
}

ComponentSession welcomed(ComponentSession session, const Welcome& welcome) {
  session.session_id = welcome.session_id;
  session.epoch = welcome.epoch;
  return session;
}

std::string legal_messages(Role role, State state) {
  std::vector<std::string> legal;
  for (const Transition& transition : kTransitions) {
    const bool applies = (transition.roles & only(role)) != 0 && (transition.from & in(state)) != 0;
    if (applies && !transition.trigger.is_local()) legal.emplace_back(name_of(transition.trigger.message));
  }
  return legal.empty() ? "no message" : listed(legal);
}

}  // namespace copepod::session
