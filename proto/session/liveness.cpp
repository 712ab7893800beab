#include "session/liveness.hpp"

#include <algorithm>
#include <cmath>

namespace copepod::session {

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
