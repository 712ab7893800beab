#include <csignal>
#include <fstream>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "coupled_run.hpp"

namespace copepod::protocol_test {
namespace {

LinkSettings at(const std::string& endpoint, const std::string& session = "secret") {
  LinkSettings settings;
  settings.endpoint = endpoint;
  settings.session = session;
  return settings;
}

TEST(Address, SecondCouplerOnOneIpcPathIsRefused) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path("coupler.ipc");
  const Link first(at(endpoint));
  EXPECT_THROW(Link second(at(endpoint)), Refused);
}

TEST(Address, LeftoversOfADeadCouplerAreNoObstacle) {
  const TemporaryFolder folder;
  const int left_over = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  folder.path("coupler.ipc").copy(address.sun_path, sizeof address.sun_path - 1);
  ASSERT_EQ(bind(left_over, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  close(left_over);
  std::ofstream(folder.path("coupler.ipc.lock")) << "1\n";
  EXPECT_NO_THROW(Link link(at("ipc://" + folder.path("coupler.ipc"))));
}

TEST(Address, TakenTcpPortIsRefused) {
  const Link first(at(tcp_endpoint()));
  EXPECT_THROW(Link second(at(tcp_endpoint())), Refused);
}

TEST(Address, NonsenseIsRefusedBeforeAnythingIsBound) {
  EXPECT_THROW(Link link(at("udp://127.0.0.1:47613")), CaseError);
  EXPECT_THROW(Link link(at("ipc://relative/path")), CaseError);
  EXPECT_THROW(Link link(at("tcp://127.0.0.1")), CaseError);
  EXPECT_THROW(Link link(at("tcp://127.0.0.1:99999")), CaseError);
  EXPECT_THROW(Link link(at("tcp://*:47613")), CaseError);
  EXPECT_THROW(Link link(at("ipc:///" + std::string(200, 'x'))), CaseError);
}

TEST(Address, StrangerWithAnotherTokenEndsWith65AndTheRunGoesOnWithoutIt) {
  const TemporaryFolder folder;
  const std::string endpoint = "ipc://" + folder.path("coupler.ipc");
  std::atomic<int> stop{0};
  LinkSettings settings = at(endpoint, "another secret");
  settings.stop_signal = [&] { return stop.load(); };
  Link link(settings);
  ChildProcess stranger(fake_fluid_command(endpoint, {}));
  auto code = stop_after(stranger, stop);
  EXPECT_THROW(link.await_components(), Interrupted);
  EXPECT_EQ(code.get(), 65);
}

TEST(Address, SecondFluidIsRefused) {
  CoupledRun run({}, {});
  run.begin();
  ChildProcess second(fake_fluid_command("ipc://" + run.folder.path("coupler.ipc"), {}));
  EXPECT_NO_THROW(run.advance(2000));
  EXPECT_EQ(second.wait(), 65);
}

TEST(CommandLine, BadOptionsEndWith2) {
  EXPECT_EQ(ChildProcess({fake_fluid_command("", {})[0], "--nonsense"}).wait(), 2);
  EXPECT_EQ(ChildProcess({fake_fluid_command("", {})[0]}).wait(), 2);
}

TEST(CommandLine, CapabilitiesAndHelpEndWith0) {
  EXPECT_EQ(ChildProcess({fake_fluid_command("", {})[0], "--capabilities"}).wait(), 0);
  EXPECT_EQ(ChildProcess({fake_fluid_command("", {})[0], "--help"}).wait(), 0);
}

}  // namespace
}  // namespace copepod::protocol_test
