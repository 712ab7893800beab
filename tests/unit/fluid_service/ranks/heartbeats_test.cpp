#include "ranks/heartbeats.hpp"

#include <array>

#include <gtest/gtest.h>

namespace copepod::fluid {
namespace {

/// Ranks 1 and 2 as rank 0 sees them; looks every 0.1 s.
class WatchedRanks : public testing::Test {
 protected:
  void beat() {
    for (Heartbeat& reading : readings) ++reading.beats;
  }
  RankVerdict look() {
    now_s += 0.1;
    return watch.look(readings, now_s);
  }

  std::array<Heartbeat, 2> readings{Heartbeat{.rank = 1, .waits = true}, Heartbeat{.rank = 2, .waits = true}};
  RankWatch watch;
  double now_s = 100.0;
};

TEST_F(WatchedRanks, AreFrozenOnceTheyHaveNotBeatenForTheSilenceLimit) {
  for (int i = 0; i < 20; ++i) {
    beat();
    EXPECT_FALSE(look().frozen);
  }
  double frozen_after_s = 0.0;
  for (int i = 1; i < 40 && frozen_after_s == 0.0; ++i) {
    ++readings[0].beats;
    if (const RankVerdict verdict = look(); verdict.frozen) {
      EXPECT_EQ(*verdict.frozen, 2);
      frozen_after_s = 0.1 * i;
    }
  }
  EXPECT_NEAR(frozen_after_s, RankWatch::silence_s, 0.11);
}

TEST_F(WatchedRanks, AreExcusedWhenRankZeroWasAwayItself) {
  beat();
  EXPECT_FALSE(look().frozen);
  now_s += 60.0;
  EXPECT_FALSE(look().frozen);
  EXPECT_FALSE(look().frozen);
}

TEST_F(WatchedRanks, TheOneThatDoesNotWaitIsAwaited) {
  EXPECT_EQ(look().awaited, 0);
  readings[1].waits = false;
  EXPECT_EQ(look().awaited, 2);
  readings[0].waits = false;
  EXPECT_EQ(look().awaited, 1);
}

TEST_F(WatchedRanks, ShowThatTheyMoveOn) {
  readings[0].progress = 7;
  EXPECT_FALSE(look().progressed);
  EXPECT_FALSE(look().progressed);
  ++readings[0].progress;
  EXPECT_TRUE(look().progressed);
  EXPECT_FALSE(look().progressed);
}

}  // namespace
}  // namespace copepod::fluid
