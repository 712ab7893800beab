
#include <arpa/inet.h>
#include <array>
#include <filesystem>
#include <fstream>
#include <sys/socket.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <zmq.hpp>

#include "contract/errors.hpp"
#include "transport/endpoint.hpp"
#include "transport/lanes.hpp"

namespace copepod::transport {
namespace {

using namespace std::chrono_literals;

struct KeyPair {
  KeyPair() { zmq_curve_keypair(public_key.data(), secret_key.data()); }
  [[nodiscard]] std::string known() const { return public_key.data(); }
  [[nodiscard]] std::string secret() const { return secret_key.data(); }

  std::array<char, 41> public_key{};
  std::array<char, 41> secret_key{};
};

/// A coupler that admits a fluid and a body.
class Door : public testing::Test {
 protected:
  Door()
      : router(bind_router(endpoint(),
                           CouplerKeys{coupler.secret(), {{fluid.known(), "fluid"}, {body.known(), "body"}}})) {}

  [[nodiscard]] static std::string endpoint() { return "tcp://127.0.0.1:" + std::to_string(20000 + getpid() % 12000); }

  [[nodiscard]] std::unique_ptr<Dealer> knock(const std::optional<ComponentKeys>& keys) const {
    auto dealer = connect_dealer(endpoint(), "stranger", keys);
    dealer->send(std::as_bytes(std::span("hello", 5)));
    return dealer;
  }

  bool turns_away(Dealer& dealer) {
    const auto end = std::chrono::steady_clock::now() + 5s;
    Frame frame;
    while (!dealer.turned_away() && std::chrono::steady_clock::now() < end) {
      if (router->receive(frame, 10ms)) return false;
    }
    return dealer.turned_away();
  }

  KeyPair coupler, fluid, body, stranger;
  std::unique_ptr<Router> router;
};

TEST_F(Door, HoldersOfAnAdmittedKeyComeInUnderTheNameOfTheirRole) {
  for (const auto& [pair, name] : {std::pair(fluid, "fluid"), std::pair(body, "body")}) {
    const auto dealer = knock(ComponentKeys{pair.secret(), coupler.known()});
    Frame frame;
    const auto end = std::chrono::steady_clock::now() + 5s;
    while (!router->receive(frame, 100ms) && std::chrono::steady_clock::now() < end) continue;
    EXPECT_EQ(frame.bytes().size(), 5U);
    EXPECT_EQ(frame.identity, name);
    EXPECT_FALSE(dealer->turned_away());
  }
}

TEST_F(Door, StrangersAreTurnedAwayAndKnowIt) {
  const auto unknown = knock(ComponentKeys{stranger.secret(), coupler.known()});
  EXPECT_TRUE(turns_away(*unknown)) << "a key that is not admitted";
  const auto elsewhere = knock(ComponentKeys{fluid.secret(), stranger.known()});
  EXPECT_TRUE(turns_away(*elsewhere)) << "the key of another coupler";
  const auto keyless = knock(std::nullopt);
  EXPECT_TRUE(turns_away(*keyless)) << "no key";
}

TEST_F(Door, RefusedKeysAndConnectionsThatStallAreRemarked) {
  const auto unknown = knock(ComponentKeys{stranger.secret(), coupler.known()});
  EXPECT_TRUE(turns_away(*unknown));
  const int silent = socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(endpoint().substr(endpoint().rfind(':') + 1))));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(connect(silent, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  std::string remarks;
  const auto end = std::chrono::steady_clock::now() + 30s;
  Frame frame;
  while (remarks.find("has not sent a message") == std::string::npos && std::chrono::steady_clock::now() < end) {
    router->receive(frame, 10ms);
    for (std::string remark = router->next_remark(); !remark.empty(); remark = router->next_remark()) remarks += remark;
  }
  close(silent);
  EXPECT_NE(remarks.find("A connection from 127.0.0.1 was refused (its key is not one"), std::string::npos) << remarks;
  EXPECT_NE(remarks.find("A connection from 127.0.0.1:"), std::string::npos) << remarks;
  EXPECT_NE(remarks.find("has not sent a message"), std::string::npos) << remarks;
}

TEST(Endpoint, NeedsKeysWhereOtherMachinesCanListen) {
  for (const char* here :
       {"ipc:///tmp/x", "tcp://127.0.0.1:5000", "tcp://127.8.9.1:5000", "tcp://localhost:5000", "tcp://[::1]:5000"}) {
    EXPECT_NO_THROW(require_keys_off_this_machine(here, false)) << here;
  }
  for (const char* anywhere : {"tcp://*:5000", "tcp://0.0.0.0:5000", "tcp://10.0.0.1:5000", "tcp://eth0:5000",
                               "tcp://127.0.0.1.example.org:5000", "tcp://[::]:5000"}) {
    EXPECT_THROW(require_keys_off_this_machine(anywhere, false), CaseError) << anywhere;
    EXPECT_NO_THROW(require_keys_off_this_machine(anywhere, true)) << anywhere;
  }
  EXPECT_THROW(bind_router("tcp://0.0.0.0:1", {}), CaseError);
  EXPECT_THROW(connect_dealer("tcp://10.0.0.1:5000", "a", {}), CaseError);
}

class KeyFile : public testing::Test {
 protected:
  void write(const std::string& text, std::filesystem::perms permissions = std::filesystem::perms::owner_read) {
    std::ofstream(path) << text;
    std::filesystem::permissions(path, permissions);
  }
  ~KeyFile() override { std::filesystem::remove(path); }

  const std::string path = testing::TempDir() + "copepod-" + std::to_string(getpid()) + ".key";
  const KeyPair own, other;
};

TEST_F(KeyFile, IsReadAsItWasWritten) {
  write("secret " + own.secret() + "\ncoupler " + other.known() + "\n");
  EXPECT_EQ(read_component_keys(path).secret, own.secret());
  EXPECT_EQ(read_component_keys(path).coupler, other.known());
}

TEST_F(KeyFile, ThatIsMissingBrokenOrOpenToOthersIsRefused) {
  EXPECT_THROW(read_component_keys(path), CaseError);
  write("secret " + own.secret() + "\n", std::filesystem::perms::owner_read | std::filesystem::perms::group_read);
  EXPECT_THROW(read_component_keys(path), CaseError);
  std::filesystem::remove(path);
  write("secret " + own.secret() + "\n");
  EXPECT_THROW(read_component_keys(path), CaseError);
  EXPECT_THROW(read_coupler_keys(path), CaseError);
  std::filesystem::remove(path);
  write("secret tooshort\ncoupler " + other.known() + "\n");
  EXPECT_THROW(read_component_keys(path), CaseError);
}

}  // namespace
}  // namespace copepod::transport
