#pragma once

#include <array>
#include <cstdint>
#include <string_view>

#include "contract/words.hpp"
#include "session/messages.hpp"

namespace copepod::session {

/// States of a component's data lane.
enum class State : std::uint8_t {
  connected,      ///< Hello sent
  greeted,        ///< Welcome received
  configured,     ///< solver made, no step done
  ready,          ///< between two steps
  stepping,       ///< works on a step; requests wait in the queue
  checkpointing,  ///< writes or reads a state; requests wait in the queue
  done,           ///< the coupler ended the run
  failed,         ///< a Failure was sent, or the coupler refused us
  orphaned,       ///< the coupler is gone
};

/// What happens inside the component.
enum class LocalEvent : std::uint8_t {
  work_done,     ///< what the last request asked for is finished, bulk update included
  work_failed,   ///< the solver threw
  coupler_lost,  ///< no ping for too long, or disconnected for too long
};

/// What a component does about a message.
enum class Work : std::uint8_t {
  none,
  accept_welcome,
  make_solver,
  read_state,
  send_kinematics,
  compute_loads,  ///< reply, then the bulk update
  advance_bodies,
  decide,
  write_state,
  send_summary,
  confirm_end,
  report_failure,
  end_process,
};

/// Sets of roles and states, as bits.
using Roles = std::uint8_t;
using States = std::uint16_t;
constexpr Roles only(Role role) { return static_cast<Roles>(1U << static_cast<unsigned>(role)); }
constexpr States in(State state) { return static_cast<States>(1U << static_cast<unsigned>(state)); }
inline constexpr Roles any_role = only(Role::fluid) | only(Role::body) | only(Role::controller);
inline constexpr States while_running = in(State::connected) | in(State::greeted) | in(State::configured) |
                                        in(State::ready) | in(State::stepping) | in(State::checkpointing);

inline constexpr States before_a_step = in(State::greeted) | in(State::configured) | in(State::ready);

/// A message, or an event inside the component.
struct Trigger {
  MessageKind message = MessageKind::none;
  LocalEvent local = LocalEvent::work_done;  ///< counts only if there is no message

  constexpr Trigger(MessageKind kind) : message(kind) {}  // NOLINT(google-explicit-constructor): reads as a table
  constexpr Trigger(LocalEvent event) : local(event) {}   // NOLINT(google-explicit-constructor)
  constexpr bool operator==(const Trigger&) const = default;
  [[nodiscard]] constexpr bool is_local() const { return message == MessageKind::none; }
};

/// One row: in any of `from`, for any of `roles`, `trigger` leads to `to` (or to the same state) and to
/// `work`.
struct Transition {
  Roles roles = 0;
  States from = 0;
  Trigger trigger = LocalEvent::work_done;
  bool stays = false;  ///< the state does not change
  State to = State::connected;
  Work work = Work::none;
  MessageKind reply = MessageKind::none;
};

constexpr Transition row(Roles roles, States from, Trigger trigger, State to, Work work, MessageKind reply) {
  return {roles, from, trigger, false, to, work, reply};
}
constexpr Transition stay(Roles roles, States from, Trigger trigger, Work work, MessageKind reply) {
  return {roles, from, trigger, true, State::connected, work, reply};
}

/// The protocol of the data lane. What is not in it is illegal. The server, the coupler's own guard, the
/// documentation and the conformance tests are driven by these rows.
// clang-format off
inline constexpr std::array kTransitions = {
  row (any_role,          in(State::connected),                        MessageKind::welcome,            State::greeted,       Work::accept_welcome,  MessageKind::none),
  row (any_role,          in(State::connected),                        MessageKind::refusal,            State::failed,        Work::end_process,     MessageKind::none),
  row (only(Role::fluid), before_a_step,                               MessageKind::fluid_setup,        State::configured,    Work::make_solver,     MessageKind::configured),
  row (only(Role::body),  before_a_step,                               MessageKind::body_setup,         State::configured,    Work::make_solver,     MessageKind::configured),
  row (only(Role::controller), before_a_step,                          MessageKind::controller_setup,   State::configured,    Work::make_solver,     MessageKind::configured),
  row (any_role,          in(State::configured),                       MessageKind::restore,            State::checkpointing, Work::read_state,      MessageKind::restored),
  row (only(Role::fluid), in(State::configured) | in(State::ready),    MessageKind::kinematics,         State::stepping,      Work::compute_loads,   MessageKind::loads),
  stay(only(Role::body),  in(State::configured) | in(State::ready),    MessageKind::kinematics_request,                       Work::send_kinematics, MessageKind::kinematics),
  row (only(Role::body),  in(State::configured) | in(State::ready),    MessageKind::applied_loads,      State::stepping,      Work::advance_bodies,  MessageKind::kinematics),
  row (only(Role::controller), in(State::configured) | in(State::ready), MessageKind::observation,      State::stepping,      Work::decide,          MessageKind::action),
  row (any_role,          in(State::ready),                            MessageKind::save,               State::checkpointing, Work::write_state,     MessageKind::saved),
  row (any_role,          in(State::stepping) | in(State::checkpointing), LocalEvent::work_done,        State::ready,         Work::none,            MessageKind::none),
  stay(any_role,          before_a_step,                               LocalEvent::work_done,                                 Work::none,            MessageKind::none),
  stay(any_role,          in(State::configured) | in(State::ready),    MessageKind::summarise,                                Work::send_summary,    MessageKind::summary),
  row (any_role,          before_a_step,                               MessageKind::finish,             State::done,          Work::confirm_end,     MessageKind::finished),
  row (any_role,          while_running,                               LocalEvent::work_failed,         State::failed,        Work::report_failure,  MessageKind::failure),
  row (any_role,          while_running,                               LocalEvent::coupler_lost,        State::orphaned,      Work::end_process,     MessageKind::none),
};
// clang-format on

/// The row for a trigger, or null if the state does not allow it.
constexpr const Transition* find_transition(Role role, State state, Trigger trigger) {
  for (const Transition& transition : kTransitions) {
    const bool applies = (transition.roles & only(role)) != 0 && (transition.from & in(state)) != 0;
    if (applies && transition.trigger == trigger) return &transition;
  }
  return nullptr;
}

constexpr State next_state(const Transition& transition, State state) {
  return transition.stays ? state : transition.to;
}

constexpr std::string_view name_of(State state) {
  constexpr std::array<std::string_view, 9> names = {"connected",     "greeted", "configured", "ready",   "stepping",
                                                     "checkpointing", "done",    "failed",     "orphaned"};
  return names[static_cast<std::size_t>(state)];
}

constexpr std::string_view name_of(LocalEvent event) {
  constexpr std::array<std::string_view, 3> names = {"work done", "work failed", "coupler lost"};
  return names[static_cast<std::size_t>(event)];
}

constexpr std::string_view name_of(Work work) {
  constexpr auto names =
      words<Work>("none", "accept the welcome", "make the solver", "read the state", "send the kinematics",
                  "compute loads, reply, bulk update", "advance bodies", "decide the action", "write the state",
                  "send the summary", "confirm the end", "report the failure", "end the process");
  return names[static_cast<std::size_t>(work)].name;
}

}  // namespace copepod::session
