#include "remote/link.hpp"

#include <span>
#include <sstream>

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

#include "components.hpp"
#include "memory_coupling.hpp"
#include "misbehaviour.hpp"
#include "remote/remote_solvers.hpp"

namespace copepod::coupler {
namespace {

FluidSetup fluid_setup() {
  FluidSetup setup;
  setup.density_kg_per_m3 = 1000;
  setup.kinematic_viscosity_m2_per_s = 1e-6;
  setup.bodies = {{ShapeKind::sphere, 1e-6, 0}};
  return setup;
}

BodySetup body_setup() {
  BodySetup setup;
  setup.step_s = 1e-6;
  setup.bodies.resize(1);
  setup.bodies[0].shape.radius_m = 1e-6;
  setup.bodies[0].mass_kg = 1e-12;
  setup.bodies[0].velocity_m_per_s = {1e-3, 0, 0};
  return setup;
}

/// The coupled steps, the same for local and for remote solvers.
Kinematics advance(FluidSolver& fluid, BodySolver& body, int steps) {
  Kinematics kinematics;
  AppliedLoads applied;
  body.kinematics(kinematics);
  applied.actuation.resize(0, 1);
  for (int step = 0; step < steps; ++step) {
    fluid.exchange(kinematics, applied.hydrodynamic);
    fluid.advance();
    body.step(applied, kinematics);
  }
  return kinematics;
}

TEST(Link, RemoteSolversGiveTheBitsOfLocalOnes) {
  SolverContext context;
  const auto local_fluid = doubles::constant_drag_component().make_solver(fluid_setup(), context);
  const auto local_body = doubles::free_point_component().make_solver(body_setup(), context);
  const Kinematics expected = advance(*local_fluid, *local_body, 50);

  MemoryCoupling coupling(doubles::constant_drag_component(), doubles::free_point_component());
  coupling.link->await_components();
  RemoteFluid fluid(*coupling.link, fluid_setup(), 0);
  RemoteBody body(*coupling.link, body_setup(), 0);
  const Kinematics received = advance(fluid, body, 50);
  EXPECT_EQ(received.position_m, expected.position_m);
  EXPECT_EQ(received.velocity_m_per_s, expected.velocity_m_per_s);
  EXPECT_EQ(fluid.summarise().digest, local_fluid->summarise().digest);
  EXPECT_EQ(body.summarise().digest, local_body->summarise().digest);
  coupling.link->finish();
  coupling.join();
  EXPECT_EQ(coupling.fluid_exit, ExitCode::finished);
  EXPECT_EQ(coupling.body_exit, ExitCode::finished);
}

TEST(Link, LostRequestsAndRepliesAreMadeGoodWithoutASecondStep) {
  SolverContext context;
  const auto local_fluid = doubles::constant_drag_component().make_solver(fluid_setup(), context);
  const auto local_body = doubles::free_point_component().make_solver(body_setup(), context);
  advance(*local_fluid, *local_body, 3);

  MemoryCoupling coupling(doubles::constant_drag_component(), doubles::free_point_component());
  coupling.link->await_components();
  RemoteFluid fluid(*coupling.link, fluid_setup(), 0);
  RemoteBody body(*coupling.link, body_setup(), 0);
  coupling.wire.lose_next_to("fluid-data");
  coupling.wire.lose_next_from("body-data");
  advance(fluid, body, 3);
  EXPECT_EQ(fluid.summarise().digest, local_fluid->summarise().digest);
  EXPECT_EQ(fluid.summarise().cell_updates, 3U);
  EXPECT_EQ(body.summarise().digest, local_body->summarise().digest);
  coupling.link->finish();
}

TEST(Link, StrangersLeaveALineInTheLogWhichNoTerminalObeys) {
  std::ostringstream log;
  const auto former = spdlog::default_logger();
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(log)));
  MemoryCoupling coupling(doubles::constant_drag_component(), doubles::free_point_component());
  session::Hello hello;
  hello.session_token = "a guess";
  hello.host = "\x1b[2Jthere";
  conversion::Encoder encoder;
  coupling.wire.make_dealer("guessing")->send(encoder.encode(session::Header{}, hello));
  const std::string noise = "GET / HTTP/1.1";
  coupling.wire.make_dealer("noisy")->send(std::as_bytes(std::span(noise)));
  coupling.link->await_components();
  RemoteFluid fluid(*coupling.link, fluid_setup(), 0);
  RemoteBody body(*coupling.link, body_setup(), 0);
  coupling.link->finish();
  coupling.join();
  spdlog::set_default_logger(former);
  EXPECT_NE(log.str().find("The fluid component on ?[2Jthere was refused (its session token"), std::string::npos)
      << log.str();
  EXPECT_NE(log.str().find("A message was ignored (its sender is unknown, and it is not a Hello). [2]"),
            std::string::npos)
      << log.str();
}

TEST(Link, BrokenDataLaneThatComesBackCostsNothingButTime) {
  MemoryCoupling coupling(doubles::constant_drag_component(), doubles::free_point_component());
  coupling.link->await_components();
  RemoteFluid fluid(*coupling.link, fluid_setup(), 0);
  RemoteBody body(*coupling.link, body_setup(), 0);
  coupling.wire.disconnect("fluid-data");
  std::thread mender([&coupling] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    coupling.wire.reconnect("fluid-data");
  });
  EXPECT_NO_THROW(advance(fluid, body, 2));
  mender.join();
  coupling.link->finish();
}

TEST(Link, BrokenControlLaneIsAComponentLost) {
  MemoryCoupling coupling(doubles::misbehaving(doubles::constant_drag_component(), {.slow_ms = 1200}),
                          doubles::free_point_component());
  coupling.link->await_components();
  RemoteFluid fluid(*coupling.link, fluid_setup(), 0);
  RemoteBody body(*coupling.link, body_setup(), 0);
  advance(fluid, body, 1);
  coupling.wire.disconnect("fluid-control");
  try {
    fluid.save("/dev/null");  // waits behind the bulk update
    FAIL() << "the loss was not detected";
  } catch (const ComponentLost& lost) {
    EXPECT_NE(std::string(lost.what()).find("The fluid component on host here"), std::string::npos) << lost.what();
    ASSERT_TRUE(lost.lost().has_value());
    EXPECT_EQ(lost.lost()->component, "fluid");
    EXPECT_EQ(lost.lost()->host, "here");
  }
  coupling.wire.reconnect("fluid-control");
  body.summarise();
  coupling.link->abort({ExitCode::component_lost, "coupler", "here", 0, 1, "The fluid is lost."});
  coupling.join();
  EXPECT_EQ(coupling.body_exit, ExitCode::component_lost);
}

}  // namespace
}  // namespace copepod::coupler
