#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "session/messages.hpp"
#include "session/transition_table.hpp"

namespace copepod::session {

/// What a Hello is judged against.
struct HelloExpectation {
  VersionRange versions;
  std::string session_token;
  bool role_taken = false;    ///< another component already plays this role on this lane
  std::string identity = {};  ///< with keys: name of the component whose key it holds
  bool is_wanted = true;      ///< a controller of this name is in the case
};

/// Accepted with a minor version, or refused for a reason.
struct HelloVerdict {
  std::optional<std::uint32_t> minor;
  std::string reason;        ///< for the component that is refused
  bool is_stranger = false;  ///< wrong token: not a component of this run, so its refusal does not end the run

  [[nodiscard]] bool accepted() const { return minor.has_value(); }
};

/// Decides whether a component may take part. The token comes first: a stranger learns nothing else.
HelloVerdict judge_hello(const Hello& hello, const HelloExpectation& expectation);

/// Whether the holder of the key of `identity` may act as `party` (Hello::party); without keys (empty) the token
/// decides alone.
bool is_entitled(const std::string& identity, const std::string& party);

/// Equality of secrets in a time that does not depend on where they differ.
bool same_token(const std::string& a, const std::string& b);

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

/// How long the coupler puts up with what; seconds.
struct Patience {
  double ping_every_s = 0.5;          ///< at rest
  double ping_broken_s = 0.05;        ///< while a connection is broken: the first pong shows that it is back
  double disconnected_s = 0.5;        ///< a broken connection may come back for so long, at least
  double silence_s = 3.0;             ///< a ping may stay without pong for so long
  double progress_deadline_s = 60.0;  ///< step, phase and progress may stand still for so long while work is due
  double pause_s = 1.0;               ///< a gap in the coupler's own attention that excuses the component
  double resend_s = 0.02;            ///< a request that was open for so long may be lost; twice as long at each attempt
  double slowest_bytes_per_s = 1e7;  ///< of a message that is still under way
};

/// State of a component's control lane as the coupler sees it. Times are seconds of one monotonic clock.
struct Liveness {
  double attention_s = 0.0;  ///< when the coupler last looked
  double last_ping_s = -1e300;
  double next_ping_s = -1e300;
  double ping_interval_s = 1e300;    ///< before the next one; doubles from ping to ping
  double unanswered_since_s = -1;    ///< oldest ping without a pong; negative: none
  double disconnected_since_s = -1;  ///< negative: connected
  double last_change_s = 0.0;        ///< when step, phase or progress last moved, or a request was sent
  Pong pong;                         ///< newest
};

enum class Health { fine, disconnected, silent, hung };

/// A ping was sent.
Liveness on_ping(Liveness liveness, const Patience& patience, double now_s);

/// A pong arrived. One that was overtaken by a newer one is ignored. After a silence (a network that was cut) the
/// component is not blamed for what it did not show meanwhile.
Liveness on_pong(Liveness liveness, const Pong& pong, const Patience& patience, double now_s);

/// A request was sent on the data lane: the component has the full deadline for it, and is asked after
/// `resend_after_s` whether it has arrived.
Liveness on_request(Liveness liveness, const Patience& patience, double resend_after_s, double now_s);

/// The coupler looks, after it has read every message that had arrived. If it was away for a while itself (a
/// checkpoint, a suspended machine), the component's clocks start anew.
Liveness on_look(Liveness liveness, bool connected, const Patience& patience, double now_s);

/// @param work_due  the component has a request to answer
Health judge(const Liveness& liveness, bool work_due, const Patience& patience, double now_s);

/// How long an answer may take before it is worth asking whether the request has arrived: longer for large
/// messages, and twice as long at each attempt.
double resend_after_s(const Patience& patience, std::size_t message_bytes, std::uint32_t attempt);

/// Whether the open request, or its reply, got lost: a pong to a ping that was sent `after_s` later than the
/// request shows that the component waits for a request, or has answered it. Wrong suspicions cost a message
/// and nothing else, since a repeated request is not computed again.
bool was_lost(const Liveness& liveness, std::uint64_t sequence, double sent_s, double after_s);

bool ping_is_due(const Liveness& liveness, const Patience& patience, double now_s);

/// "is gone (its connection broke and did not come back: the process has died)":
/// follows the component's name.
std::string describe(Health health, const Liveness& liveness, double now_s);

}  // namespace copepod::session
