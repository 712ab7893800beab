#include "session/liveness.hpp"

#include <gtest/gtest.h>

namespace copepod::session {
namespace {

const Patience kPatience{};  // ping every 0.5 s, silence 3 s, progress 60 s

Pong pong(std::int64_t step, Phase phase, std::uint64_t progress = 0) {
  return {0, step, phase, progress, 0, 0};
}

/// Looks every 0.1 s from one time to another, pinging as it is due; `answers` says whether pongs come back.
Liveness watch(Liveness liveness, double from_s, double to_s, bool answers, const Pong& answer = {}) {
  for (double now = from_s; now < to_s; now += 0.1) {
    if (ping_is_due(liveness, kPatience, now)) liveness = on_ping(liveness, now);
    if (answers) liveness = on_pong(liveness, answer, now);
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
  Liveness liveness = on_request({}, 0);
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
  Liveness liveness = on_request({}, 0);
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
  liveness = on_ping(liveness, 1);
  liveness = on_look(liveness, true, kPatience, 1);
  liveness = on_look(liveness, true, kPatience, 100);  // the coupler wrote a checkpoint for 99 s
  EXPECT_EQ(judge(liveness, true, kPatience, 100), Health::fine);
}

TEST(Liveness, TellsThatARequestWasLost) {
  Liveness liveness = on_pong({}, {0, 3, Phase::waiting, 0, 4, 4}, 10);
  EXPECT_TRUE(was_lost(liveness, 5, 8.9, kPatience)) << "the component waits and has not seen request 5";
  EXPECT_FALSE(was_lost(liveness, 5, 9.5, kPatience)) << "it may still be on its way";
  EXPECT_TRUE(was_lost(liveness, 4, 8.9, kPatience))
      << "it has answered request 4, but the reply did not come";
  liveness = on_pong(liveness, {0, 3, Phase::exchanging, 0, 5, 4}, 20);
  EXPECT_FALSE(was_lost(liveness, 5, 8.9, kPatience)) << "the component works on request 5";
  liveness = on_pong(liveness, {0, 3, Phase::advancing, 0, 4, 4}, 20);
  EXPECT_FALSE(was_lost(liveness, 5, 8.9, kPatience)) << "request 5 waits behind the bulk update";
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
