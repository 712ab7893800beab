#pragma once

#include <cstdint>
#include <string>

#include "session/header.hpp"
#include "session/transition_table.hpp"

namespace copepod::session {

/// What the coupler remembers of its conversation with one component: the component's state as the same table
/// predicts it, and the request that is not answered yet.
struct CouplerSession {
  Role role = Role::fluid;
  State state = State::connected;  ///< of the component, once it has answered
  std::uint64_t session_id = 0;
  std::uint64_t epoch = 0;
  std::uint64_t sequence = 0;  ///< of the newest request
  std::uint32_t attempt = 0;
  std::int64_t step = -1;                   ///< of the newest request
  MessageKind request = MessageKind::none;  ///< not answered yet, or none
  MessageKind expected_reply = MessageKind::none;
  bool follows_up = false;  ///< a fluid that has replied with loads and now does the bulk update of the step

  bool operator==(const CouplerSession&) const = default;
  [[nodiscard]] bool waits() const { return request != MessageKind::none; }
  /// Step that the component is working on: that of the open request or of the bulk update after it; −1 if it
  /// has nothing to do.
  [[nodiscard]] std::int64_t current_step() const { return waits() || follows_up ? step : -1; }
};

/// A request that may be sent, or why not.
struct Asked {
  CouplerSession session;
  std::string problem;  ///< empty: send it
};

/// What a message from the component means.
struct Heard {
  enum class Kind {
    reply,    ///< the answer to the open request
    failure,  ///< the component's run is over
    stale,    ///< a repeated or foreign answer: ignore it
    refuse,   ///< the component broke the protocol: `problem`, "it answered …"
  };
  CouplerSession session;
  Kind kind = Kind::stale;
  std::string problem;
};

/// The component was sent its Welcome.
CouplerSession welcomed(CouplerSession session, std::uint64_t session_id, std::uint64_t epoch);

/// The coupler is to send a request about `step`.
Asked ask(const CouplerSession& session, MessageKind request, std::int64_t step);

/// The open request is sent once more.
CouplerSession ask_again(CouplerSession session);

/// A message arrived from the component's data lane.
Heard hear(const CouplerSession& session, MessageKind kind, const Header& header);

/// Header of the open request.
Header header_of(const CouplerSession& session);

}  // namespace copepod::session
