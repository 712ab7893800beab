#pragma once

#include <memory>
#include <thread>

#include <spdlog/logger.h>
#include <spdlog/sinks/null_sink.h>

#include "component/control_lane.hpp"
#include "component/server.hpp"
#include "in_memory.hpp"
#include "remote/link.hpp"

namespace copepod::coupler {

/// A whole coupling in one process: both components in threads, the Link in the test's hands, nothing but
/// memory between them.
class MemoryCoupling {
 public:
  MemoryCoupling(FluidComponent fluid, BodyComponent body, LinkSettings settings = {})
      : fluid_component_(std::move(fluid)), body_component_(std::move(body)) {
    settings.session = "token";
    link = std::make_unique<Link>(settings, wire.make_router());
    fluid_thread_ = std::thread([this] {
      SolverContext context;
      component::ServedFluid solver(fluid_component_, context);
      fluid_exit = serve(solver, context, fluid_component_.capabilities, 1);
    });
    body_thread_ = std::thread([this] {
      SolverContext context;
      component::ServedBody solver(body_component_, context);
      body_exit = serve(solver, context, body_component_.capabilities, 2);
    });
  }

  void join() {
    if (fluid_thread_.joinable()) fluid_thread_.join();
    if (body_thread_.joinable()) body_thread_.join();
  }

  ~MemoryCoupling() { join(); }

  transport::InMemoryWire wire;  ///< lanes are called fluid-data, fluid-control, body-data, body-control
  std::unique_ptr<Link> link;
  ExitCode fluid_exit{};
  ExitCode body_exit{};

 private:
  ExitCode serve(component::ServedSolver& solver, SolverContext& context, const Capabilities& capabilities,
                 std::uint64_t instance) {
    const std::string name(name_of(solver.role()));
    const auto data_lane = wire.make_dealer(name + "-data");
    spdlog::logger log("test", std::make_shared<spdlog::sinks::null_sink_mt>());
    component::Vitals vitals(context);
    session::Hello hello;
    hello.role = solver.role();
    hello.capabilities = capabilities;
    hello.session_token = "token";
    hello.host = "here";
    hello.instance = instance;
    const component::ControlLane control(wire.make_dealer(name + "-control"), vitals, log, hello, {60, 60});
    return component::Server(*data_lane, solver, vitals, log, hello, 10).run();
  }

  FluidComponent fluid_component_;
  BodyComponent body_component_;
  std::thread fluid_thread_;
  std::thread body_thread_;
};

}  // namespace copepod::coupler
