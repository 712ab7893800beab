#pragma once

#include <cstdint>
#include <string>

#include "session/messages.hpp"
#include "session/transition_table.hpp"

namespace copepod::session {

/// How long a component waits for a coupler that has gone quiet; seconds.
struct OrphanPatience {
  double orphan_after_s = 10.0;  ///< without a ping
  double disconnected_s = 3.0;   ///< without a connection
  double pause_s = 1.0;          ///< a gap in the component's own attention that excuses the coupler
};

/// Signs of life of the coupler, as a component sees them. Times are seconds of one monotonic clock.
struct CouplerSigns {
  double last_ping_s = 0.0;          ///< or when the Welcome came
  double disconnected_since_s = -1;  ///< negative: connected
  double attention_s = 0.0;          ///< when the component last looked
};

/// The component looks, after it has read every message that had arrived. If it was away for a while itself (a
/// suspended job or machine), the coupler's clocks start anew: it was suspended too.
inline CouplerSigns on_look(CouplerSigns signs, bool connected, const OrphanPatience& patience, double now_s) {
  const bool was_away = now_s - signs.attention_s > patience.pause_s;
  if (was_away) signs.last_ping_s = now_s;
  if (connected) signs.disconnected_since_s = -1;
  if (!connected && (was_away || signs.disconnected_since_s < 0)) signs.disconnected_since_s = now_s;
  signs.attention_s = now_s;
  return signs;
}

/// Why the component must take its coupler for lost; empty as long as it need not.
inline std::string orphan_reason(const CouplerSigns& signs, const OrphanPatience& patience, double now_s) {
  if (signs.disconnected_since_s >= 0 && now_s - signs.disconnected_since_s > patience.disconnected_s)
    return "The coupler is gone (its connection broke and did not come back). Look at the coupler's log.";
  if (now_s - signs.last_ping_s > patience.orphan_after_s)
    return "The coupler is silent (no ping for longer than the component waits). Look at the coupler's log.";
  return {};
}

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
