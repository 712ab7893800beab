#include <cstring>
#include <fstream>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "in_memory.hpp"
#include "transport/lanes.hpp"

namespace copepod::transport {
namespace {

using namespace std::chrono_literals;

/// A router's wait also ends when a connection changes; this one does not.
bool receive_within(Router& router, Frame& frame, Duration wait) {
  const auto end = std::chrono::steady_clock::now() + wait;
  while (std::chrono::steady_clock::now() < end) {
    if (router.receive(frame, 100ms)) return true;
  }
  return false;
}

/// The parameter is the kind of wire.
class ZeroMq : public testing::TestWithParam<std::string> {
 protected:
  void TearDown() override {
    for (const char* suffix : {"", ".lock"}) unlink((path_ + suffix).c_str());
  }

  void SetUp() override {
    const int descriptor = socket(AF_INET6, SOCK_STREAM, 0);
    sockaddr_in6 address{};
    address.sin6_family = AF_INET6;
    address.sin6_addr = IN6ADDR_LOOPBACK_INIT;
    const bool has_ipv6 = bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    close(descriptor);
    if (GetParam() == "tcp_ipv6" && !has_ipv6) GTEST_SKIP() << "this machine has no IPv6";
  }

  /// Unlikely to be used by another run of the tests at the same time.
  [[nodiscard]] std::string endpoint() const {
    if (GetParam() == "ipc") return "ipc://" + path_;
    const std::string host = GetParam() == "tcp" ? "127.0.0.1" : GetParam() == "tcp_by_name" ? "localhost" : "[::1]";
    return "tcp://" + host + ":" + std::to_string(20000 + getpid() % 12000);
  }

 private:
  std::string path_ = "/tmp/copepod-" + std::to_string(getpid()) + "-lane";
};

TEST_P(ZeroMq, CarriesMessagesOfAllSizesBothWays) {
  const auto router = bind_router(endpoint());
  const auto dealer = connect_dealer(endpoint(), "a");
  Frame frame;
  for (const std::size_t size : {0U, 1U, 100U, 10'000'000U}) {
    const std::string text(size, 'x');
    ASSERT_TRUE(dealer->send(bytes_of(text)));
    ASSERT_TRUE(receive_within(*router, frame, 5s));
    EXPECT_EQ(frame.peer, "a");
    EXPECT_EQ(text_of(frame), text);
    ASSERT_TRUE(router->send("a", frame.bytes()));
    Frame back;
    ASSERT_TRUE(dealer->receive(back, 5s));
    EXPECT_EQ(text_of(back), text);
  }
}

TEST_P(ZeroMq, WaitsNoLongerThanItIsToldTo) {
  const auto router = bind_router(endpoint());
  const auto dealer = connect_dealer(endpoint(), "a");
  Frame frame;
  const auto start = std::chrono::steady_clock::now();
  EXPECT_FALSE(dealer->receive(frame, 50ms));
  EXPECT_FALSE(router->receive(frame, 50ms));
  const auto waited = std::chrono::steady_clock::now() - start;
  EXPECT_GE(waited, 50ms);  // the router's wait may end early, when the dealer connects
  EXPECT_LT(waited, 500ms);
}

TEST_P(ZeroMq, RouterDoesNotWaitForAPeerThatReadsNothing) {
  const auto router = bind_router(endpoint());
  const auto dealer = connect_dealer(endpoint(), "a");
  Frame frame;
  dealer->send(bytes_of("here"));
  ASSERT_TRUE(receive_within(*router, frame, 5s));
  const std::string text(10'000, 'x');
  const auto start = std::chrono::steady_clock::now();
  int sent = 0;
  while (router->send("a", bytes_of(text))) ASSERT_LT(++sent, 100'000);
  for (int i = 0; i < 10; ++i) router->send("a", bytes_of(text));
  EXPECT_LT(std::chrono::steady_clock::now() - start, 5s);
}

TEST_P(ZeroMq, RouterNoticesThatAPeerIsGoneAndThatItIsBack) {
  const auto router = bind_router(endpoint());
  Frame frame;
  {
    const auto dealer = connect_dealer(endpoint(), "a");
    dealer->send(bytes_of("here"));
    ASSERT_TRUE(receive_within(*router, frame, 5s));
    const auto seen_end = std::chrono::steady_clock::now() + 5s;  // the message may be faster than the event
    while (!router->connected("a") && std::chrono::steady_clock::now() < seen_end) router->receive(frame, 1ms);
    EXPECT_TRUE(router->connected("a"));
    EXPECT_FALSE(router->connected("b"));
  }
  const auto end = std::chrono::steady_clock::now() + 5s;
  while (router->connected("a") && std::chrono::steady_clock::now() < end) router->receive(frame, 10ms);
  EXPECT_FALSE(router->connected("a"));
  while (router->send("a", bytes_of("hello?")) && std::chrono::steady_clock::now() < end) router->receive(frame, 10ms);
  EXPECT_FALSE(router->send("a", bytes_of("hello?")));
  const auto dealer = connect_dealer(endpoint(), "a");
  dealer->send(bytes_of("back"));
  const auto back_end = std::chrono::steady_clock::now() + 2s;
  while (!router->connected("a") && std::chrono::steady_clock::now() < back_end) router->receive(frame, 10ms);
  EXPECT_TRUE(router->connected("a"));
}

TEST_P(ZeroMq, DealerNoticesThatTheCouplerComesAndGoes) {
  const auto dealer = connect_dealer(endpoint(), "a");
  EXPECT_FALSE(dealer->connected());
  Frame frame;
  const auto wait_until = [&](bool connected) {
    const auto end = std::chrono::steady_clock::now() + 3s;
    while (dealer->connected() != connected && std::chrono::steady_clock::now() < end) dealer->receive(frame, 10ms);
    return dealer->connected() == connected;
  };
  {
    const auto router = bind_router(endpoint());
    EXPECT_TRUE(wait_until(true));
  }
  EXPECT_TRUE(wait_until(false));
  EXPECT_EQ(dealer->address_is_gone(), GetParam() == "ipc");
  const auto next_router = bind_router(endpoint());
  EXPECT_TRUE(wait_until(true)) << "the connection is made again by itself";
  EXPECT_FALSE(dealer->address_is_gone());
}

TEST_P(ZeroMq, MessagesWaitForACouplerThatStartsLater) {
  const auto dealer = connect_dealer(endpoint(), "a");
  dealer->send(bytes_of("early"));
  const auto router = bind_router(endpoint());
  Frame frame;
  ASSERT_TRUE(receive_within(*router, frame, 5s));
  EXPECT_EQ(text_of(frame), "early");
}

INSTANTIATE_TEST_SUITE_P(Lanes, ZeroMq, testing::Values("ipc", "tcp", "tcp_by_name", "tcp_ipv6"),
                         [](const auto& instance) { return instance.param; });

TEST(ZeroMqAddress, OfAnIpcSocketNeverReplacesAFileOfOthers) {
  const std::string path = "/tmp/copepod_kept_" + std::to_string(getpid());
  for (const char* suffix : {"", ".lock"}) {
    const std::string name = path + suffix;
    std::ofstream(name) << "work of a year";
    EXPECT_THROW(bind_router("ipc://" + path), Refused) << name;
    std::string text;
    std::getline(std::ifstream(name) >> std::ws, text);
    EXPECT_EQ(text, "work of a year") << name;
    unlink(name.c_str());
  }
  auto router = bind_router("ipc://" + path);
  unlink(path.c_str());
  std::ofstream(path) << "work of a year";
  router.reset();  // which removes its socket
  EXPECT_EQ(unlink(path.c_str()), 0);
  unlink((path + ".lock").c_str());
}

TEST(ZeroMqAddress, ThatMakesNoSenseIsACaseError) {
  EXPECT_THROW(bind_router("nonsense"), CaseError);
  EXPECT_THROW(connect_dealer("nonsense", "a"), CaseError);
  EXPECT_THROW(bind_router("ipc:///no/such/folder/coupler.ipc"), Refused);
}

}  // namespace
}  // namespace copepod::transport
