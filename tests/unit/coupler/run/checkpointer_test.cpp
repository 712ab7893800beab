#include "run/checkpointer.hpp"

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

using namespace std::chrono_literals;
const CheckpointSchedule::Clock::time_point start{};

TEST(CheckpointSchedule, IsDueAtMultiplesOfItsStepsOnce) {
  CheckpointSchedule schedule(100, 0.0, 0, start);
  EXPECT_FALSE(schedule.due(0, start));
  EXPECT_FALSE(schedule.due(99, start));
  EXPECT_TRUE(schedule.due(100, start));
  schedule.written(100, start);
  EXPECT_FALSE(schedule.due(100, start));
  EXPECT_TRUE(schedule.due(200, start));
}

TEST(CheckpointSchedule, IsDueAfterItsSeconds) {
  CheckpointSchedule schedule(0, 10.0, 0, start);
  EXPECT_FALSE(schedule.due(5, start + 9s));
  EXPECT_TRUE(schedule.due(5, start + 10s));
  schedule.written(5, start + 12s);
  EXPECT_FALSE(schedule.due(6, start + 21s));
  EXPECT_TRUE(schedule.due(6, start + 22s));
}

TEST(CheckpointSchedule, IsNeverDueWhereARunBeginsOrWhenSwitchedOff) {
  EXPECT_FALSE(CheckpointSchedule(100, 0.0, 300, start).due(300, start));
  EXPECT_FALSE(CheckpointSchedule(0, 0.0, 0, start).due(100, start + 1h));
}

}  // namespace
}  // namespace copepod::coupler
