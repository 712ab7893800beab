#include <array>
#include <chrono>
#include <csignal>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "component/progress.hpp"
#include "ranks/mpi_communicator.hpp"

namespace copepod::fluid {
namespace {

using namespace std::chrono_literals;

/// Rank 0 looks on from another thread while its solver's thread waits in `wait`.
template <class Wait, class Look>
void look_on_while(const Wait& wait, const Look& look) {
  std::thread observer([&] {
    std::this_thread::sleep_for(700ms);
    look();
  });
  wait();
  observer.join();
}

TEST(RankHeartbeats, NamesTheRankThatTheOthersWaitFor) {
  MpiCommunicator ranks;
  const int last = ranks.size() - 1;
  std::array<std::int64_t, 1> value{1};
  if (ranks.rank() == last) std::this_thread::sleep_for(1500ms);
  int awaited = -1;
  look_on_while([&] { ranks.sum_to_all(value); }, [&] { awaited = awaited_rank(); });
  if (ranks.rank() == 0) {
    EXPECT_EQ(awaited, last);
  }
  EXPECT_EQ(awaited_rank(), 0) << "nobody waits any more";
}

TEST(RankHeartbeats, ProgressOfAnotherRankCountsAsProgress) {
  MpiCommunicator ranks;
  if (ranks.size() == 1) GTEST_SKIP() << "there is no other rank";
  std::array<std::int64_t, 1> value{1};
  const std::uint64_t before = progress_counter();
  if (ranks.rank() == 1) {
    for (int i = 0; i < 150; ++i) {
      std::this_thread::sleep_for(10ms);
      report_progress();
    }
  }
  ranks.sum_to_all(value);
  if (ranks.rank() == 0) {
    EXPECT_GT(progress_counter(), before);
  }
}

/// Somebody suspends the last rank; it goes on after rank 0 has given it up.
void suspend(pid_t process) {
  std::this_thread::sleep_for(300ms);
  kill(process, SIGSTOP);
  std::this_thread::sleep_for(3700ms);
  kill(process, SIGCONT);
}

TEST(RankHeartbeats, FrozenRankIsNamedWithinThreeSeconds) {
  MpiCommunicator ranks;
  if (ranks.size() == 1) GTEST_SKIP() << "the coupler looks after rank 0";
  const int last = ranks.size() - 1;
  std::array<std::int64_t, 1> process{ranks.rank() == last ? getpid() : 0};
  ranks.sum_to_all(process);
  if (ranks.rank() != 0) {
    std::this_thread::sleep_for(4500ms);  // in which one of them is suspended, and rank 0 finds out
    ranks.report_failure({});             // so that nobody uses MPI to take leave of a rank that has given up
    return;
  }
  std::thread somebody(suspend, static_cast<pid_t>(process[0]));
  const auto start = std::chrono::steady_clock::now();
  try {
    ranks.sum_to_all(process);
    ADD_FAILURE() << "nobody was missed";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().rank, last);
    EXPECT_EQ(failure.report().code, ExitCode::component_lost);
    EXPECT_LT(std::chrono::steady_clock::now() - start, 3300ms);
  }
  somebody.join();
}

}  // namespace
}  // namespace copepod::fluid
