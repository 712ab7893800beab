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

TEST(ThreadRanks, WhatAnAbandonedExchangeOfferedIsTakenBack) {
  const auto exchange_with = [](Communicator& own, int peer, std::int64_t sent, std::int64_t& received) {
    const std::array<Communicator::Message, 1> message = {
        {{peer, std::as_bytes(std::span(&sent, 1)), std::as_writable_bytes(std::span(&received, 1))}}};
    own.start_exchange(message)();
  };
  std::int64_t received_by_1 = 0;
  SolverContext context;
  std::int64_t abandoned = -1, received = 0;
  {
    ThreadRanks ranks(2, context, [&](Communicator& own) {
      own.sum_to_all({});
      exchange_with(own, 0, 3, received_by_1);
    });
    Communicator& leader = ranks.leader();
    {
      const std::int64_t sent = 1;
      std::array<Communicator::Message, 5> messages;  // more than below: their memory is not the next exchange's
      messages.fill({1, std::as_bytes(std::span(&sent, 1)), std::as_writable_bytes(std::span(&abandoned, 1))});
      static_cast<void>(leader.start_exchange(messages));
    }
    leader.sum_to_all({});
    exchange_with(leader, 1, 2, received);
  }
  EXPECT_EQ(abandoned, -1);
  EXPECT_EQ(received, 3);
  EXPECT_EQ(received_by_1, 2);
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
