#pragma once

#include <string>

namespace copepod::session {

/// How long a component waits for a coupler that has gone quiet; seconds.
struct OrphanPatience {
  double orphan_after_s = 10.0;  ///< without a ping
  double disconnected_s = 3.0;   ///< without a connection
};

/// Signs of life of the coupler, as a component sees them. Times are seconds of one monotonic clock.
struct CouplerSigns {
  double last_ping_s = 0.0;          ///< or when the Welcome came
  double disconnected_since_s = -1;  ///< negative: connected
};

/// Why the component must take its coupler for lost; empty as long as it need not.
inline std::string orphan_reason(const CouplerSigns& signs, const OrphanPatience& patience, double now_s) {
  if (signs.disconnected_since_s >= 0 && now_s - signs.disconnected_since_s > patience.disconnected_s) {
    return "The coupler is gone (its connection broke and did not come back). Look at the coupler's log.";
  }
  if (now_s - signs.last_ping_s > patience.orphan_after_s) {
    return "The coupler is silent (no ping for longer than the component waits). Look at the coupler's log.";
  }
  return {};
}

}  // namespace copepod::session
