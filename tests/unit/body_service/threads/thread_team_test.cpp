#include "threads/thread_team.hpp"

#include <atomic>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace copepod::body {
namespace {

TEST(ThreadTeam, DoesEveryPartOfALoopOnce) {
  for (const int threads : {1, 2, 5}) {
    ThreadTeam team(threads);
    for (const int parts : {0, 1, 2, 1000}) {
      std::vector<int> done(static_cast<std::size_t>(parts));
      for (int loop = 0; loop < 20; ++loop) {
        team.share(parts, [&](std::int64_t part, int thread) {
          EXPECT_TRUE(thread >= 0 && thread < threads);
          ++done[static_cast<std::size_t>(part)];
        });
      }
      EXPECT_EQ(done, std::vector<int>(done.size(), 20)) << threads << " threads";
    }
  }
}

TEST(ThreadTeam, WorksInSeveralThreadsAtOnce) {
  ThreadTeam team(2);
  std::atomic<int> arrived = 0;
  team.share(2, [&](std::int64_t, int) {  // each waits for the other one
    ++arrived;
    arrived.notify_all();
    for (int now = arrived; now < 2; now = arrived) arrived.wait(now);
  });
  EXPECT_EQ(arrived, 2);
}

TEST(ThreadTeam, ThrowsWhatTheFirstPartThrowsAndGoesOn) {
  for (const int threads : {1, 2, 4}) {
    ThreadTeam team(threads);
    for (int loop = 0; loop < 50; ++loop) {
      try {
        team.share(100, [](std::int64_t part, int) {
          if (part >= 40) throw std::runtime_error(std::to_string(part));
        });
        ADD_FAILURE() << "no error";
      } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "40") << threads << " threads";
      }
      std::atomic<int> done = 0;
      team.share(100, [&](std::int64_t, int) { ++done; });
      EXPECT_EQ(done, 100);
    }
  }
}

}  // namespace
}  // namespace copepod::body
