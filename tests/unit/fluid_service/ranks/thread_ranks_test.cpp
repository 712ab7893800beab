#include "ranks/thread_ranks.hpp"

#include <array>
#include <atomic>
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

// Whichever of the two ranks waits, or gives its side up, copies the messages of both.
TEST(ThreadRanks, OneRankCompletesAnExchangeForBoth) {
  for (const bool leader_abandons : {false, true}) {
    std::atomic<int> stage = 0;
    const auto reach = [&stage](int next) {
      stage = next;
      stage.notify_one();
    };
    const std::int64_t sent[] = {2, 3};
    std::int64_t received[] = {0, 0};
    const auto start = [&](Communicator& own) {
      const auto rank = static_cast<std::size_t>(own.rank());
      const std::array<Communicator::Message, 1> message = {{{1 - own.rank(), std::as_bytes(std::span(&sent[rank], 1)),
                                                              std::as_writable_bytes(std::span(&received[rank], 1))}}};
      return own.start_exchange(message);
    };
    SolverContext context;
    ThreadRanks ranks(2, context, [&](Communicator& own) {
      const auto finish = start(own);
      reach(1);
      if (leader_abandons) stage.wait(1);
      finish();
      EXPECT_EQ(received[1], 2);
      if (!leader_abandons) reach(2);
    });
    stage.wait(0);
    if (leader_abandons) {
      static_cast<void>(start(ranks.leader()));
      EXPECT_EQ(received[0], 3);
      reach(2);
    } else {
      const auto never_finished = start(ranks.leader());
      stage.wait(1);
      EXPECT_EQ(received[0], 3);
    }
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
