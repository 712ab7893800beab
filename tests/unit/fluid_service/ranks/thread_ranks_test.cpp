#include "ranks/thread_ranks.hpp"

#include <array>
#include <chrono>
#include <thread>

#include <gtest/gtest.h>

#include "contract/errors.hpp"

namespace copepod::fluid {
namespace {

// What all communicators have in common is in tests/mpi.

TEST(ThreadRanks, ARequestToStopEndsAWait) {
  SolverContext context;
  ThreadRanks ranks(2, context, [](Communicator& own) {
    std::array<std::int64_t, 1> value = {1};
    EXPECT_THROW(own.max_to_all(value), PeerFailed);  // asleep until rank 0 reports
  });
  context.request_stop(143);
  std::array<std::int64_t, 1> received = {0};
  const std::array<Communicator::Message, 1> message = {{{1, {}, std::as_writable_bytes(std::span(received))}}};
  const auto wait = ranks.leader().start_exchange(message);
  try {
    wait();
    ADD_FAILURE() << "nothing was sent";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::terminated);
    ranks.leader().report_failure({error.code(), "fluid", "here", 0, 7, error.what()});
  }
}

TEST(ThreadRanks, AFailureWakesRanksThatSleep) {
  SolverContext context;
  ThreadRanks ranks(3, context, [](Communicator& own) {
    if (own.rank() == 1) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      own.report_failure({ExitCode::storage_failed, "fluid", "here", 1, 4, "no room"});
      return;
    }
    std::array<std::int64_t, 1> value = {1};
    EXPECT_THROW(own.sum_to_all(value), PeerFailed);
  });
  std::array<std::int64_t, 1> value = {1};
  try {
    ranks.leader().sum_to_all(value);
    ADD_FAILURE() << "rank 1 failed";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().rank, 1);
    EXPECT_EQ(failure.code(), ExitCode::storage_failed);
  }
}

}  // namespace
}  // namespace copepod::fluid
