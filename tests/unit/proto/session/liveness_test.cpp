#include <vector>

#include <gtest/gtest.h>

#include "session/coupler_session.hpp"

namespace copepod::session {
namespace {

const Patience kPatience{};  // ping every 0.5 s, silence 3 s, progress 60 s

Pong pong(std::int64_t step, Phase phase, std::uint64_t progress = 0) { return {0, step, phase, progress, 0, 0}; }

/// Looks every 0.1 s from one time to another, pinging as it is due; `answers`: whether pongs come back.
Liveness watch(Liveness liveness, double from_s, double to_s, bool answers, const Pong& answer = {}) {
  for (double now = from_s; now < to_s; now += 0.1) {
    if (ping_is_due(liveness, kPatience, now)) liveness = on_ping(liveness, kPatience, now);
    if (answers) liveness = on_pong(liveness, answer, kPatience, now);
    liveness = on_look(liveness, true, kPatience, now);
  }
  return liveness;
}

TEST(Liveness, IsFineWhilePongsComeAndNothingIsDue) {
  const Liveness liveness = watch({}, 0, 500, true, pong(3, Phase::waiting));
  EXPECT_EQ(judge(liveness, false, kPatience, 500), Health::fine);
}

TEST(Liveness, IsSilentOnceAPingStaysUnansweredForTheLimit) {
  Liveness liveness = watch({}, 0, 10, true, pong(3, Phase::waiting));
  liveness = watch(liveness, 10, 12.9, false);
  EXPECT_EQ(judge(liveness, false, kPatience, 12.9), Health::fine);
  liveness = watch(liveness, 12.9, 14, false);
  EXPECT_EQ(judge(liveness, false, kPatience, 14), Health::silent);
}

TEST(Liveness, IsHungWhenWorkIsDueAndNothingMoves) {
  Liveness liveness = on_request({}, kPatience, 0.02, 0);
  liveness = watch(liveness, 0, 59, true, pong(3, Phase::exchanging));
  EXPECT_EQ(judge(liveness, true, kPatience, 59), Health::fine);
  liveness = watch(liveness, 59, 61, true, pong(3, Phase::exchanging));
  EXPECT_EQ(judge(liveness, true, kPatience, 61), Health::hung);
}

TEST(Liveness, IsHungInABulkUpdateThatNobodyWaitsForYet) {
  const Liveness liveness = watch({}, 0, 61, true, pong(3, Phase::advancing));
  EXPECT_EQ(judge(liveness, false, kPatience, 61), Health::hung);
}

TEST(Liveness, AnyMovementGrantsTheWholeDeadlineAgain) {
  Liveness liveness = on_request({}, kPatience, 0.02, 0);
  liveness = watch(liveness, 0, 50, true, pong(3, Phase::exchanging, 1));
  liveness = watch(liveness, 50, 100, true, pong(3, Phase::exchanging, 2));
  EXPECT_EQ(judge(liveness, true, kPatience, 100), Health::fine);
}

TEST(Liveness, ABrokenConnectionMayComeBackForAMoment) {
  Liveness liveness = on_look({}, false, kPatience, 0.1);
  EXPECT_EQ(judge(liveness, false, kPatience, 0.5), Health::fine);
  EXPECT_EQ(judge(liveness, false, kPatience, 0.7), Health::disconnected);
  liveness = on_look(liveness, true, kPatience, 0.5);
  EXPECT_EQ(judge(liveness, false, kPatience, 0.7), Health::fine);
}

TEST(Liveness, TheCouplersOwnAbsenceExcusesTheComponent) {
  Liveness liveness = watch({}, 0, 1, true, pong(3, Phase::exchanging));
  liveness = on_ping(liveness, kPatience, 1);
  liveness = on_look(liveness, true, kPatience, 1);
  liveness = on_look(liveness, true, kPatience, 100);  // the coupler wrote a checkpoint for 99 s
  EXPECT_EQ(judge(liveness, true, kPatience, 100), Health::fine);
}

TEST(Liveness, ABrokenConnectionMayComeBackAfterTheCouplersOwnAbsence) {
  Liveness liveness = watch({}, 0, 1, true, pong(3, Phase::exchanging));
  liveness = on_look(liveness, false, kPatience, 1);
  liveness = on_look(liveness, false, kPatience, 100);  // both were suspended
  EXPECT_EQ(judge(liveness, true, kPatience, 100.4), Health::fine);
  EXPECT_EQ(judge(liveness, true, kPatience, 100.6), Health::disconnected);
}

TEST(Liveness, ACutNetworkIsNoHangAndPausesItsClock) {
  Patience patience;
  patience.silence_s = 30;
  Liveness liveness = on_request({}, patience, 0.02, 0);
  liveness = watch(liveness, 0, 50, true, pong(3, Phase::exchanging));
  liveness = watch(liveness, 50, 79, false);
  EXPECT_EQ(judge(liveness, true, patience, 79), Health::fine);
  liveness = watch(liveness, 79, 88, true, pong(3, Phase::exchanging));
  EXPECT_EQ(judge(liveness, true, patience, 88), Health::fine);
  liveness = watch(liveness, 88, 90, true, pong(3, Phase::exchanging));
  EXPECT_EQ(judge(liveness, true, patience, 90), Health::hung);
}

Pong pong_of_ping_at(double sent_s, Phase phase, std::uint64_t received, std::uint64_t replied) {
  return {static_cast<std::uint64_t>(1e9 * sent_s), 3, phase, 0, received, replied};
}

TEST(Liveness, TellsThatARequestWasLost) {
  Liveness liveness = on_pong({}, pong_of_ping_at(10, Phase::waiting, 4, 4), kPatience, 10.1);
  EXPECT_TRUE(was_lost(liveness, 5, 9.9, 0.02)) << "the component waits and has not seen request 5";
  EXPECT_FALSE(was_lost(liveness, 5, 9.99, 0.02)) << "it may still be on its way";
  EXPECT_FALSE(was_lost(liveness, 5, 10.05, 0.02)) << "the pong came after the request, but the ping before";
  EXPECT_TRUE(was_lost(liveness, 4, 9.9, 0.02)) << "it has answered request 4, but the reply did not come";
  liveness = on_pong(liveness, pong_of_ping_at(20, Phase::exchanging, 5, 4), kPatience, 20);
  EXPECT_FALSE(was_lost(liveness, 5, 9.9, 0.02)) << "the component works on request 5";
  liveness = on_pong(liveness, pong_of_ping_at(21, Phase::advancing, 4, 4), kPatience, 21);
  EXPECT_FALSE(was_lost(liveness, 5, 9.9, 0.02)) << "request 5 waits behind the bulk update";
}

TEST(Liveness, APongThatWasOvertakenTellsNothing) {
  Liveness liveness = on_pong({}, pong_of_ping_at(10, Phase::exchanging, 5, 4), kPatience, 10.1);
  const double before_s = liveness.last_change_s;
  liveness = on_pong(liveness, pong_of_ping_at(9, Phase::waiting, 4, 4), kPatience, 10.2);
  EXPECT_EQ(liveness.pong.received_sequence, 5U);
  EXPECT_EQ(liveness.last_change_s, before_s);
}

TEST(Liveness, AsksSoonAfterARequestAndThenMoreAndMoreSeldom) {
  Liveness liveness = on_ping({}, kPatience, 0);
  liveness = on_request(liveness, kPatience, 0.02, 0.1);
  std::vector<int> pings_ms;
  for (int ms = 100; ms < 2000; ++ms) {
    if (!ping_is_due(liveness, kPatience, 1e-3 * ms)) continue;
    liveness = on_ping(liveness, kPatience, 1e-3 * ms);
    pings_ms.push_back(ms);
  }
  const std::vector<int> expected_ms{120, 160, 240, 400, 720, 1220, 1720};
  ASSERT_EQ(pings_ms.size(), expected_ms.size());
  for (std::size_t i = 0; i < expected_ms.size(); ++i) EXPECT_NEAR(pings_ms[i], expected_ms[i], 10);
}

TEST(Liveness, AsksNoMoreThanAtRestWhileRequestsAreAnsweredAtOnce) {
  Liveness liveness = on_ping({}, kPatience, 0);
  int pings = 0;
  for (int ms = 0; ms < 2000; ++ms) {
    liveness = on_request(liveness, kPatience, 0.02, 1e-3 * ms);
    if (!ping_is_due(liveness, kPatience, 1e-3 * ms)) continue;
    liveness = on_ping(liveness, kPatience, 1e-3 * ms);
    ++pings;
  }
  EXPECT_EQ(pings, 3);
}

TEST(Liveness, AsksOftenWhileAConnectionIsBroken) {
  Liveness liveness = on_ping({}, kPatience, 0);
  liveness = on_look(liveness, false, kPatience, 0.01);
  EXPECT_FALSE(ping_is_due(liveness, kPatience, 0.04));
  EXPECT_TRUE(ping_is_due(liveness, kPatience, 0.06));
}

TEST(Liveness, WaitsLongerForLargeMessagesAndWithEachAttempt) {
  EXPECT_DOUBLE_EQ(resend_after_s(kPatience, 0, 0), 0.02);
  EXPECT_DOUBLE_EQ(resend_after_s(kPatience, 0, 3), 0.16);
  EXPECT_DOUBLE_EQ(resend_after_s(kPatience, 10'000'000, 0), 1.02);
  EXPECT_LT(resend_after_s(kPatience, 0, 1'000'000), 10) << "never gives up altogether";
}

TEST(Liveness, DescribesWhatHappened) {
  Liveness liveness;
  liveness.unanswered_since_s = 1;
  liveness.pong.phase = Phase::advancing;
  liveness.last_change_s = 2;
  EXPECT_EQ(describe(Health::silent, liveness, 5),
            "is frozen (no answer to a ping for 4 s: the process is suspended or its host unreachable)");
  EXPECT_EQ(describe(Health::hung, liveness, 72),
            "hangs (it answers pings but has been advancing without progress for 70 s)");
  EXPECT_EQ(describe(Health::fine, liveness, 5), "is fine");
}

}  // namespace
}  // namespace copepod::session
