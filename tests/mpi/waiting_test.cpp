#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <iostream>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "test_on_ranks.hpp"

namespace copepod::fluid {
namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

void busy_wait(double seconds) {
  const double end = wall_seconds() + seconds;
  while (wall_seconds() < end) {
  }
}

TEST_ON_RANKS(Waiting, UsesLessThanFivePercentOfACore) {
  std::array<std::byte, 100> data{};
  ranks.broadcast(data);
  const double cpu = cpu_seconds();
  const double wall = wall_seconds();
  if (ranks.rank() == 0) std::this_thread::sleep_for(std::chrono::seconds(2));
  ranks.broadcast(data);
  if (ranks.rank() == 0) return;
  const double share = (cpu_seconds() - cpu) / (wall_seconds() - wall);
  std::cout << "rank " << ranks.rank() << " waited with " << 100.0 * share << " % of a core\n";
  EXPECT_LT(share, 0.05);
}

TEST_ON_RANKS(Waiting, SeesAMessageSoonAfterItCame) {
  if (ranks.size() != 2) GTEST_SKIP() << "measures two ranks on their own cores";
  for (const double delay_s : {50e-6, 200e-6, 1e-3, 5e-3}) {
    std::array<std::int64_t, 1> nanoseconds = {0};
    std::vector<double> lags;
    for (int round = 0; round < 201; ++round) {
      // Both agree on a start, rank 0 sends its time after the delay, rank 1 compares it with the time of
      // receipt: ranks of one machine share the clock.
      std::array<std::int64_t, 1> one = {1};
      ranks.sum_to_all(one);
      if (ranks.rank() == 0) {
        busy_wait(delay_s);
        nanoseconds[0] = std::chrono::steady_clock::now().time_since_epoch().count();
      }
      ranks.broadcast(std::as_writable_bytes(std::span(nanoseconds)));
      if (ranks.rank() == 1)
        lags.push_back(
            1e-9 * static_cast<double>(std::chrono::steady_clock::now().time_since_epoch().count() - nanoseconds[0]));
    }
    if (ranks.rank() != 1) continue;
    std::sort(lags.begin(), lags.end());
    const double median_s = lags[lags.size() / 2];
    std::cout << "after " << 1e6 * delay_s << " us of waiting a message is seen " << 1e6 * median_s << " us late, "
              << "9 of 10 within " << 1e6 * lags[lags.size() * 9 / 10] << " us\n";
    // The fastest one: other programs on this machine delay some of them; Backoff has tests of its own.
    EXPECT_LT(lags.front(), delay_s / 8 + 200e-6);
  }
}

}  // namespace
}  // namespace copepod::fluid
