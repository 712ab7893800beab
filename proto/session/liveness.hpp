#pragma once

#include <cstdint>
#include <string>

#include "session/messages.hpp"

namespace copepod::session {

/// How long the coupler puts up with what; seconds.
struct Patience {
  double ping_every_s = 0.5;
  double disconnected_s = 0.5;  ///< a broken connection may come back for so long
  double silence_s = 3.0;       ///< a ping may stay without pong for so long
  double progress_deadline_s =
      60.0;               ///< step, phase and progress may stand still for so long while work is due
  double pause_s = 1.0;   ///< a gap in the coupler's own attention that excuses the component
  double resend_s = 1.0;  ///< an idle component is asked again after so long
};

/// What the coupler knows of a component's control lane. Times are seconds of one monotonic clock.
struct Liveness {
  double attention_s = 0.0;  ///< when the coupler last looked
  double last_ping_s = -1e300;
  double unanswered_since_s = -1;    ///< oldest ping without a pong; negative: none
  double disconnected_since_s = -1;  ///< negative: connected
  double last_pong_s = -1e300;
  double last_change_s = 0.0;  ///< when step, phase or progress last moved, or a request was sent
  Pong pong;                   ///< newest
};

enum class Health { fine, disconnected, silent, hung };

/// A ping was sent.
Liveness on_ping(Liveness liveness, double now_s);

/// A pong arrived.
Liveness on_pong(Liveness liveness, const Pong& pong, double now_s);

/// A request was sent on the data lane: the component has the full deadline for it.
Liveness on_request(Liveness liveness, double now_s);

/// The coupler looks, after it has read every message that had arrived. If it was away for a while itself (a
/// checkpoint, a suspended machine), the component's clocks start anew.
Liveness on_look(Liveness liveness, bool connected, const Patience& patience, double now_s);

/// @param work_due  the component has a request to answer
Health judge(const Liveness& liveness, bool work_due, const Patience& patience, double now_s);

/// Whether the open request, or its reply, got lost with a connection: the newest pong, later than the
/// request by `resend_s`, tells that the component waits for a request, or has answered it.
bool was_lost(const Liveness& liveness, std::uint64_t sequence, double sent_s, const Patience& patience);

bool ping_is_due(const Liveness& liveness, const Patience& patience, double now_s);

/// "is gone (its connection broke and did not come back: the process has died)": to follow the component's
/// name.
std::string describe(Health health, const Liveness& liveness, double now_s);

}  // namespace copepod::session
