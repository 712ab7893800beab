#include <array>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "test_on_ranks.hpp"

namespace copepod::fluid {
namespace {

std::span<const std::byte> bytes_of(const std::vector<std::int64_t>& values) {
  return std::as_bytes(std::span(values));
}
std::span<std::byte> bytes_of(std::vector<std::int64_t>& values) { return std::as_writable_bytes(std::span(values)); }

TEST_ON_RANKS(OneCommunicator, BroadcastsFromRankZero) {
  std::vector<std::int64_t> values(3000, ranks.rank());
  if (ranks.rank() == 0) std::iota(values.begin(), values.end(), 5);
  ranks.broadcast(bytes_of(values));
  EXPECT_EQ(values.front(), 5);
  EXPECT_EQ(values.back(), 3004);
}

TEST_ON_RANKS(OneCommunicator, SumsIntegersExactly) {
  constexpr std::int64_t large = (std::int64_t{1} << 53) + 1;  // not a double
  std::array<std::int64_t, 2> values = {large, -ranks.rank()};
  ranks.sum_to_all(values);
  const std::int64_t n = ranks.size();
  EXPECT_EQ(values[0], n * large);
  EXPECT_EQ(values[1], -n * (n - 1) / 2);

  std::array<std::int64_t, 2> to_leader = {large, -ranks.rank()};
  ranks.sum_to_leader(to_leader);
  if (ranks.rank() == 0) {
    EXPECT_EQ(to_leader, values);
  }
}

TEST_ON_RANKS(OneCommunicator, SumsDigestsModuloTwoToThe64) {
  std::array<std::int64_t, 1> value = {std::numeric_limits<std::int64_t>::max()};
  ranks.sum_to_all(value);
  const auto expected =
      static_cast<std::uint64_t>(ranks.size()) * static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(static_cast<std::uint64_t>(value[0]), expected);
}

TEST_ON_RANKS(OneCommunicator, FindsTheMaximum) {
  std::array<std::int64_t, 2> values = {-1 - ranks.rank(), ranks.rank()};
  ranks.max_to_all(values);
  EXPECT_EQ(values[0], -1);
  EXPECT_EQ(values[1], ranks.size() - 1);
}

TEST_ON_RANKS(OneCommunicator, ExchangesWithBothNeighboursInARing) {
  const int next = (ranks.rank() + 1) % ranks.size();
  const int previous = (ranks.rank() + ranks.size() - 1) % ranks.size();
  for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{200000}}) {
    const std::vector<std::int64_t> up(length, 100 + ranks.rank());
    const std::vector<std::int64_t> down(length, 200 + ranks.rank());
    std::vector<std::int64_t> from_below(length);
    std::vector<std::int64_t> from_above(length);
    // On one and two ranks both messages have the same peer: they match in the order in which they
    // are listed.
    const std::array<Communicator::Message, 2> messages = {
        {{next, bytes_of(up), bytes_of(from_above)}, {previous, bytes_of(down), bytes_of(from_below)}}};
    ranks.start_exchange(messages)();
    const bool same_peer = next == previous;
    EXPECT_EQ(from_above, std::vector<std::int64_t>(length, (same_peer ? 100 : 200) + next));
    EXPECT_EQ(from_below, std::vector<std::int64_t>(length, (same_peer ? 200 : 100) + previous));
  }
}

TEST_ON_RANKS(OneCommunicator, KeepsSeveralExchangesAndCollectiveCallsApart) {
  constexpr std::size_t largest = 5;
  const auto values_of = [](int sender, int receiver, std::size_t number) {
    return std::vector<std::int64_t>((number + static_cast<std::size_t>(sender + receiver)) % largest,
                                     100 * sender + 10 * receiver + static_cast<int>(number));
  };
  struct Exchange {
    std::vector<std::vector<std::int64_t>> sent, received;
    std::function<void()> wait;
  };
  std::array<Exchange, 4> exchanges;
  const auto start = [&](std::size_t number) {
    Exchange& exchange = exchanges[number];
    std::vector<Communicator::Message> messages;
    for (int peer = 0; peer < ranks.size(); ++peer) {
      exchange.sent.push_back(values_of(ranks.rank(), peer, number));
      exchange.received.push_back(std::vector<std::int64_t>(exchange.sent.back().size(), -1));
    }
    for (int peer = 0; peer < ranks.size(); ++peer) {
      const auto i = static_cast<std::size_t>(peer);
      messages.push_back({peer, bytes_of(std::as_const(exchange.sent[i])), bytes_of(exchange.received[i])});
    }
    exchange.wait = ranks.start_exchange(messages);
  };
  // Ranks start their exchanges at different times, and finish them in another order.
  std::array<std::int64_t, 1> one = {1};
  if (ranks.rank() % 2 == 0) start(0);
  ranks.sum_to_leader(one);
  if (ranks.rank() % 2 != 0) start(0);
  for (std::size_t number = 1; number < exchanges.size(); ++number) start(number);
  std::array<std::int64_t, 1> highest = {ranks.rank()};
  ranks.max_to_all(highest);
  EXPECT_EQ(highest[0], ranks.size() - 1);
  for (const std::size_t number : {std::size_t{2}, std::size_t{0}, std::size_t{3}, std::size_t{1}}) {
    exchanges[number].wait();
    for (int peer = 0; peer < ranks.size(); ++peer)
      EXPECT_EQ(exchanges[number].received[static_cast<std::size_t>(peer)], values_of(peer, ranks.rank(), number));
  }
}

TEST_ON_RANKS(OneCommunicator, GivesUpAnExchangeThatNobodyFinishes) {
  const int next = (ranks.rank() + 1) % ranks.size();
  std::vector<std::int64_t> received(10, -1);
  const std::vector<std::int64_t> sent(10, 1);
  if (ranks.rank() == 0 && ranks.size() > 1) {
    const std::array<Communicator::Message, 1> message = {{{next, bytes_of(sent), bytes_of(received)}}};
    const auto abandoned = ranks.start_exchange(message);
  }
  std::array<std::int64_t, 1> one = {1};
  ranks.sum_to_all(one);  // the communicator still works, and nothing was written
  EXPECT_EQ(one[0], ranks.size());
  EXPECT_EQ(received, std::vector<std::int64_t>(10, -1));
}

}  // namespace
}  // namespace copepod::fluid
