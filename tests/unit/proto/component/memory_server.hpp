#pragma once

#include <memory>
#include <optional>
#include <thread>

#include <spdlog/logger.h>
#include <spdlog/sinks/null_sink.h>

#include "component/control_lane.hpp"
#include "component/server.hpp"
#include "conversion/codec.hpp"
#include "in_memory.hpp"

namespace copepod::component {

/// A server in a thread of its own, and the coupler's end of its data lane in the test's hands.
class MemoryServer {
 public:
  explicit MemoryServer(FluidComponent fluid, double connect_deadline_s = 5.0)
      : MemoryServer(std::move(fluid), {}, session::Role::fluid, connect_deadline_s) {}
  explicit MemoryServer(BodyComponent body) : MemoryServer({}, std::move(body), session::Role::body, 5.0) {}

  ~MemoryServer() {
    if (thread_.joinable()) thread_.join();
  }

  /// The next message of the server, decoded into `decoder`.
  session::MessageKind receive() {
    transport::Frame frame;
    if (!router->receive(frame, std::chrono::seconds(5))) return session::MessageKind::none;
    last.assign(frame.bytes().begin(), frame.bytes().end());
    return decoder.parse(last);
  }

  template <class... Body>
  void send(const Body&... body) {
    router->send("data", encoder.encode(header, body...));
  }

  /// Sends the next request and returns the kind of the answer.
  template <class... Body>
  session::MessageKind ask(const Body&... body) {
    ++header.sequence;
    send(body...);
    return receive();
  }

  void welcome() {
    EXPECT_EQ(receive(), session::MessageKind::hello);
    send(session::Welcome{0, 4711, 1});
    header.session_id = 4711;
    header.epoch = 1;
  }

  /// What comes before the exchange of `step`.
  template <class Setup>
  void configure(const Setup& setup, std::int64_t step = 0) {
    welcome();
    header.step = step;
    EXPECT_EQ(ask(setup), session::MessageKind::configured);
  }

  FailureReport failure() {
    FailureReport report;
    decoder.read(report);
    return report;
  }

  ExitCode join() {
    thread_.join();
    return exit_code_;
  }

  transport::InMemoryWire wire;
  std::unique_ptr<transport::Router> router;
  session::Header header;
  conversion::Encoder encoder;
  conversion::Decoder decoder;
  std::vector<std::byte> last;
  SolverContext context;
  Vitals vitals{context};

 private:
  MemoryServer(FluidComponent fluid, BodyComponent body, session::Role role, double connect_deadline_s)
      : router(wire.make_router()), fluid_component_(std::move(fluid)), body_component_(std::move(body)) {
    thread_ = std::thread([this, role, connect_deadline_s] {
      if (role == session::Role::fluid) run(fluid_, connect_deadline_s);
      if (role == session::Role::body) run(body_, connect_deadline_s);
    });
  }

  void run(ServedSolver& solver, double connect_deadline_s) {
    const auto dealer = wire.make_dealer("data");
    spdlog::logger log("test", std::make_shared<spdlog::sinks::null_sink_mt>());
    session::Hello hello;
    hello.role = solver.role();
    hello.capabilities =
        solver.role() == session::Role::fluid ? fluid_component_.capabilities : body_component_.capabilities;
    hello.host = "here";
    hello.session_token = "token";
    exit_code_ = Server(*dealer, solver, vitals, log, hello, connect_deadline_s).run();
  }

  FluidComponent fluid_component_;
  BodyComponent body_component_;
  ServedFluid fluid_{fluid_component_, context};
  ServedBody body_{body_component_, context};
  ExitCode exit_code_ = ExitCode::finished;
  std::thread thread_;
};

}  // namespace copepod::component
