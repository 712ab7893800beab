#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <unistd.h>

#include <gtest/gtest.h>

#include "ranks/mpi_communicator.hpp"

namespace copepod::fluid {
namespace {

using namespace std::chrono_literals;

/// What one rank of this machine shows to the others while they are all inside calls of MPI.
class Flag {
 public:
  /// Collective; the file in the temporary folder of the machine stays there.
  Flag(MpiCommunicator& ranks, const std::string& name) {
    std::array<std::int64_t, 1> process{ranks.rank() == 0 ? getpid() : 0};
    ranks.sum_to_all(process);
    path_ = std::filesystem::temp_directory_path() / ("copepod_" + name + "_" + std::to_string(process[0]));
    std::filesystem::remove(path_);
    ranks.sum_to_all(process);
  }
  Flag(const Flag&) = delete;
  Flag& operator=(const Flag&) = delete;
  void raise() const { std::ofstream(path_).close(); }
  [[nodiscard]] bool is_raised() const { return std::filesystem::exists(path_); }

 private:
  std::filesystem::path path_;
};

template <class Condition>
void wait_until(const Condition& condition) {
  while (!condition()) std::this_thread::sleep_for(5ms);
}

TEST(RankHeartbeats, NamesTheRankThatTheOthersWaitFor) {
  SolverContext context;
  MpiCommunicator ranks{context};
  if (ranks.size() == 1) GTEST_SKIP() << "there is no other rank";
  const Flag seen(ranks, "seen");
  const int last = ranks.size() - 1;
  std::array<std::int64_t, 1> value{1};
  std::thread observer;
  if (ranks.rank() == 0) {
    observer = std::thread([&] {  // the test times out if the last rank is never named
      wait_until([&] { return context.awaited_rank() == last; });
      seen.raise();
    });
  }
  if (ranks.rank() == last) wait_until([&] { return seen.is_raised(); });
  ranks.sum_to_all(value);
  if (ranks.rank() == 0) observer.join();
  EXPECT_EQ(context.awaited_rank(), 0) << "no rank waits any more";
}

TEST(RankHeartbeats, ProgressOfAnotherRankCountsAsProgress) {
  SolverContext context;
  MpiCommunicator ranks{context};
  if (ranks.size() == 1) GTEST_SKIP() << "there is no other rank";
  std::array<std::int64_t, 1> value{1};
  const std::uint64_t before = context.progress();
  if (ranks.rank() == 1) {
    for (int i = 0; i < 150; ++i) {
      std::this_thread::sleep_for(10ms);
      context.report_progress();
    }
  }
  ranks.sum_to_all(value);
  if (ranks.rank() == 0) {
    EXPECT_GT(context.progress(), before);
  }
}

TEST(RankHeartbeats, FrozenRankIsNamed) {
  SolverContext context;
  MpiCommunicator ranks{context};
  if (ranks.size() == 1) GTEST_SKIP() << "the coupler watches rank 0";
  const Flag ready(ranks, "ready"), given_up(ranks, "given_up");
  const int last = ranks.size() - 1;
  std::array<std::int64_t, 1> process{ranks.rank() == last ? getpid() : 0};
  ranks.sum_to_all(process);
  if (ranks.rank() != 0) {
    if (ranks.rank() == last) ready.raise();  // it has left the sum
    wait_until([&] { return given_up.is_raised(); });
    ranks.report_failure({});  // rank 0 has given up: no rank may use MPI to end
    return;
  }
  wait_until([&] { return ready.is_raised(); });
  kill(static_cast<pid_t>(process[0]), SIGSTOP);
  try {
    ranks.sum_to_all(process);
    ADD_FAILURE() << "the frozen rank was not missed";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().rank, last);
    EXPECT_EQ(failure.report().code, ExitCode::component_lost);
  }
  given_up.raise();
  kill(static_cast<pid_t>(process[0]), SIGCONT);
}

}  // namespace
}  // namespace copepod::fluid
