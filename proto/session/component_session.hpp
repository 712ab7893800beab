#pragma once

#include <cstdint>
#include <string>

#include "session/header.hpp"
#include "session/messages.hpp"
#include "session/transition_table.hpp"

namespace copepod::session {

/// What a component remembers of its conversation with the coupler.
struct ComponentSession {
  Role role = Role::fluid;
  State state = State::connected;
  std::uint64_t session_id = 0;
  std::uint64_t epoch = 0;
  std::uint64_t last_sequence = 0;  ///< newest request that was accepted
  std::int64_t next_step = -1;      ///< step that the next exchange must be about

  bool operator==(const ComponentSession&) const = default;
};

/// What the server has to do about an event.
struct Action {
  enum class Kind {
    work,          ///< do `work` and answer with `reply`
    repeat_reply,  ///< send the reply of the last request again, byte for byte
    ignore,        ///< belongs to another run or was overtaken: log it, do nothing
    refuse,        ///< answer with a Failure with `reason`, then end
  };
  Kind kind = Kind::ignore;
  Work work = Work::none;
  MessageKind reply = MessageKind::none;
  std::string reason;
};

struct Outcome {
  ComponentSession session;
  Action action;
};

/// A message arrived on the data lane.
/// Exactly once: a request with the sequence number of the last one is answered with the same bytes again;
/// older ones are ignored; a number or a step that skips ahead is refused, since something was lost, and so
/// is a request without a number.
Outcome on_message(const ComponentSession& session, MessageKind kind, const Header& header);

/// Something happened inside the component.
Outcome on_event(const ComponentSession& session, LocalEvent event);

/// The coupler's Welcome names the ids that all later messages must carry.
ComponentSession welcomed(ComponentSession session, const Welcome& welcome);

/// "Setup (fluid), Finish": what the state allows, for messages to people.
std::string legal_messages(Role role, State state);

}  // namespace copepod::session
