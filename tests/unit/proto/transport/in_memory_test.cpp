#include "in_memory.hpp"

#include <cstring>
#include <thread>

#include <gtest/gtest.h>

namespace copepod::transport {
namespace {

using namespace std::chrono_literals;

TEST(InMemoryWire, CarriesMessagesBothWaysInOrder) {
  InMemoryWire wire;
  const auto router = wire.make_router();
  const auto dealer = wire.make_dealer("a");
  Frame frame;
  dealer->send(bytes_of("one"));
  dealer->send(bytes_of("three"));
  ASSERT_TRUE(router->receive(frame, 0ms));
  EXPECT_EQ(frame.peer, "a");
  EXPECT_EQ(text_of(frame), "one");
  ASSERT_TRUE(router->receive(frame, 0ms));
  EXPECT_EQ(text_of(frame), "three");
  EXPECT_FALSE(router->receive(frame, 1ms));
  EXPECT_TRUE(router->send("a", bytes_of("back")));
  ASSERT_TRUE(dealer->receive(frame, 0ms));
  EXPECT_EQ(text_of(frame), "back");
}

TEST(InMemoryWire, WakesAWaitingReceiver) {
  InMemoryWire wire;
  const auto router = wire.make_router();
  const auto dealer = wire.make_dealer("a");
  std::thread answering([&dealer] {
    Frame frame;
    while (dealer->receive(frame, 30s) && text_of(frame) != "end") dealer->send(frame.bytes());
  });
  Frame frame;
  for (int round = 0; round < 100; ++round) {
    router->send("a", bytes_of("hello"));
    EXPECT_TRUE(router->receive(frame, 30s));
  }
  router->send("a", bytes_of("end"));
  answering.join();
}

TEST(InMemoryWire, ShowsBrokenConnections) {
  InMemoryWire wire;
  const auto router = wire.make_router();
  auto dealer = wire.make_dealer("a");
  EXPECT_TRUE(router->connected("a"));
  EXPECT_FALSE(router->connected("b"));
  wire.disconnect("a");
  EXPECT_FALSE(router->connected("a"));
  EXPECT_FALSE(dealer->connected());
  EXPECT_FALSE(router->send("a", bytes_of("x")));
  wire.reconnect("a");
  EXPECT_TRUE(router->connected("a"));
  dealer.reset();
  EXPECT_FALSE(router->connected("a")) << "a dealer that is gone is disconnected";
}

TEST(InMemoryWire, LosesWhatItIsToldToLose) {
  InMemoryWire wire;
  const auto router = wire.make_router();
  const auto dealer = wire.make_dealer("a");
  Frame frame;
  wire.lose_next_from("a");
  dealer->send(bytes_of("lost"));
  EXPECT_FALSE(router->receive(frame, 0ms));
  dealer->send(bytes_of("kept"));
  EXPECT_TRUE(router->receive(frame, 0ms));
  wire.lose_next_to("a");
  router->send("a", bytes_of("lost"));
  EXPECT_FALSE(dealer->receive(frame, 0ms));
}

}  // namespace
}  // namespace copepod::transport
