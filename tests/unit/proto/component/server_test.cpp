#include "component/server.hpp"

#include <gtest/gtest.h>

#include "components.hpp"
#include "constant_drag_fluid.hpp"
#include "conversion/codec.hpp"
#include "memory_server.hpp"

namespace copepod::component {
namespace {

using session::MessageKind;

FluidSetup one_sphere_in_water() {
  FluidSetup setup;
  setup.density_kg_per_m3 = 1000;
  setup.kinematic_viscosity_m2_per_s = 1e-6;
  setup.bodies = {{ShapeKind::sphere, 1e-6, 0}};
  return setup;
}

BodySetup one_free_sphere() {
  BodySetup setup;
  setup.step_s = 0.5;
  setup.bodies.resize(1);
  setup.bodies[0].shape.radius_m = 1e-6;
  setup.bodies[0].mass_kg = 2;
  return setup;
}

Kinematics moving_at(std::int64_t step) {
  Kinematics kinematics;
  kinematics.resize(1);
  kinematics.step = step;
  kinematics.position_m.setZero();
  kinematics.orientation_wxyz.col(0) << 1, 0, 0, 0;
  kinematics.velocity_m_per_s.col(0) << 1, 0, 0;
  kinematics.angular_velocity_rad_per_s.setZero();
  return kinematics;
}

/// Counts its steps, so that a test sees what was really computed.
class CountingFluid final : public FluidSolver {
 public:
  explicit CountingFluid(int& exchanges) : exchanges_(exchanges) {}
  void exchange(const Kinematics& kinematics, Loads& loads) override {
    ++exchanges_;
    loads.resize(kinematics.bodies());
    loads.step = kinematics.step;
    loads.force_N.setConstant(exchanges_);
    loads.torque_N_m.setZero();
    if (kinematics.step == 3) loads.force_N(1, 0) = std::nan("");
    if (kinematics.step == 4) loads.resize(2);
  }
  void advance() override {}
  void save(const std::string& path) override { throw StorageError("No room for " + path + " (quota). Free some."); }
  void restore(const std::string&) override { throw std::out_of_range("no step in it"); }
  SolverSummary summarise() override { return {}; }

 private:
  int& exchanges_;
};

FluidComponent counting_component(int& exchanges) {
  return {{"counting", "1.0", {"checkpoint"}},
          [&exchanges](const FluidSetup&, SolverContext&) { return std::make_unique<CountingFluid>(exchanges); }};
}

TEST(Server, RefusesAMinorVersionThatItDidNotOffer) {
  int exchanges = 0;
  MemoryServer server(counting_component(exchanges));
  EXPECT_EQ(server.receive(), MessageKind::hello);
  server.send(session::Welcome{session::kProtocolMinor + 1, 4711, 1});
  EXPECT_EQ(server.join(), ExitCode::refused);
}

TEST(Server, ServesAFluidFromHelloToFinished) {
  MemoryServer server(doubles::constant_drag_component());
  server.configure(one_sphere_in_water());
  EXPECT_EQ(server.ask(moving_at(0)), MessageKind::loads);
  Loads loads;
  server.decoder.read(loads, 1);
  EXPECT_LT(loads.force_N(0, 0), 0);
  EXPECT_EQ(server.ask(MessageKind::summarise), MessageKind::summary);
  SolverSummary summary;
  server.decoder.read(summary);
  EXPECT_EQ(summary.cell_updates, 1U) << "the bulk update was done, although it was not requested";
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, ServesABodyFromHelloToFinished) {
  MemoryServer server(doubles::free_point_component());
  BodySetup setup = one_free_sphere();
  setup.actuators = {{ActuatorKind::world_force, 0, -1, Eigen::Vector3d::UnitY()}};
  server.configure(setup);
  session::Configured configured;
  server.decoder.read(configured);
  EXPECT_EQ(configured.driving_nodes, std::vector<double>{0});
  EXPECT_EQ(server.ask(MessageKind::kinematics_request), MessageKind::kinematics);
  AppliedLoads applied;
  applied.hydrodynamic.resize(1);
  applied.hydrodynamic.step = 0;
  applied.hydrodynamic.force_N.col(0) << 4, 0, 0;
  applied.hydrodynamic.torque_N_m.setZero();
  applied.actuation.setConstant(1, 1, 8.0);
  EXPECT_EQ(server.ask(applied), MessageKind::kinematics);
  Kinematics next;
  server.decoder.read(next, 1);
  EXPECT_EQ(next.step, 1);
  EXPECT_EQ(next.velocity_m_per_s(0, 0), 1.0);
  EXPECT_EQ(next.velocity_m_per_s(1, 0), 2.0);
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, RepeatedRequestGetsTheSameBytesAndIsNotComputedAgain) {
  int exchanges = 0;
  MemoryServer server(counting_component(exchanges));
  server.configure(one_sphere_in_water());
  ASSERT_EQ(server.ask(moving_at(0)), MessageKind::loads);
  const auto first = server.last;
  server.header.attempt = 1;
  server.send(moving_at(0));
  ASSERT_EQ(server.receive(), MessageKind::loads);
  EXPECT_EQ(server.last, first);
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  server.join();
  EXPECT_EQ(exchanges, 1);
}

TEST(Server, IllegalMessageIsAnsweredWithAFailureThatNamesTheState) {
  MemoryServer server(doubles::constant_drag_component());
  server.welcome();
  EXPECT_EQ(server.ask(MessageKind::summarise), MessageKind::failure);
  EXPECT_EQ(server.failure().code, ExitCode::refused);
  EXPECT_NE(server.failure().reason.find("in state 'greeted' allows FluidSetup, Finish"), std::string::npos);
  EXPECT_EQ(server.join(), ExitCode::refused);
}

TEST(Server, AnotherSetupBeginsAnewWithOneSolverAtATime) {
  int solvers = 0;
  struct Counted final : doubles::ConstantDragFluid {
    Counted(const FluidSetup& setup, int& count) : ConstantDragFluid(setup), solvers(++count) {}
    ~Counted() override { --solvers; }
    int& solvers;
  };
  FluidComponent component = doubles::constant_drag_component();
  component.make_solver = [&](const FluidSetup& setup, SolverContext&) {
    EXPECT_EQ(solvers, 0);
    return std::make_unique<Counted>(setup, solvers);
  };
  MemoryServer server(component);
  server.configure(one_sphere_in_water());
  EXPECT_EQ(server.ask(moving_at(0)), MessageKind::loads);
  EXPECT_EQ(server.ask(one_sphere_in_water()), MessageKind::configured);
  EXPECT_EQ(server.ask(moving_at(0)), MessageKind::loads);
  EXPECT_EQ(server.ask(MessageKind::summarise), MessageKind::summary);
  SolverSummary summary;
  server.decoder.read(summary);
  EXPECT_EQ(summary.cell_updates, 1U);
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, AnotherSetupIsRefusedWhereSnapshotsAreNotAnnounced) {
  int exchanges = 0;
  MemoryServer server(counting_component(exchanges));
  server.configure(one_sphere_in_water());
  EXPECT_EQ(server.ask(one_sphere_in_water()), MessageKind::failure);
  EXPECT_NE(server.failure().reason.find("does not announce snapshots"), std::string::npos);
  EXPECT_EQ(server.join(), ExitCode::refused);
}

TEST(Server, DamagedRequestIsTreatedLikeOneThatDidNotArrive) {
  MemoryServer server(doubles::constant_drag_component());
  server.configure(one_sphere_in_water());
  ++server.header.sequence;
  const auto request = server.encoder.encode(server.header, moving_at(0));
  std::vector<std::byte> damaged(request.begin(), request.end());
  damaged[damaged.size() / 2] ^= std::byte{4};
  server.router->send("data", damaged);
  server.send(moving_at(0));
  EXPECT_EQ(server.receive(), MessageKind::loads);
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, NonsenseThatArrivedAsItWasSentIsAnsweredWithAFailure) {
  MemoryServer server(doubles::constant_drag_component());
  server.welcome();
  std::vector<std::byte> nonsense(20 + conversion::kChecksumBytes, std::byte{0xFF});
  conversion::write_checksum(nonsense);
  server.router->send("data", nonsense);
  EXPECT_EQ(server.receive(), MessageKind::failure);
  EXPECT_EQ(server.join(), ExitCode::refused);
}

TEST(Server, GoodbyeIsSaidAgainToACouplerThatDidNotHearIt) {
  MemoryServer server(doubles::constant_drag_component());
  server.configure(one_sphere_in_water());
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  server.send(MessageKind::finish);
  EXPECT_EQ(server.receive(), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, GoodbyeIsSaidAgainOverAConnectionThatBrokeMeanwhile) {
  MemoryServer server(doubles::constant_drag_component());
  server.configure(one_sphere_in_water());
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  server.wire.disconnect("data");
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  server.wire.reconnect("data");
  server.send(MessageKind::finish);
  EXPECT_EQ(server.receive(), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, WrongNumberOfBodiesIsAFailure) {
  MemoryServer server(doubles::constant_drag_component());
  FluidSetup two = one_sphere_in_water();
  two.bodies.push_back(two.bodies[0]);
  server.configure(two);
  EXPECT_EQ(server.ask(moving_at(0)), MessageKind::failure);
  EXPECT_EQ(server.join(), ExitCode::refused);
}

class FaultyFluid : public testing::TestWithParam<std::int64_t> {};

TEST_P(FaultyFluid, LoadsThatAreNotFiniteOrTooManyAreTheFluidsOwnFailure) {
  int exchanges = 0;
  MemoryServer server(counting_component(exchanges));
  server.configure(one_sphere_in_water(), GetParam());
  EXPECT_EQ(server.ask(moving_at(GetParam())), MessageKind::failure);
  EXPECT_EQ(server.failure().code, ExitCode::solver_failed);
  EXPECT_EQ(server.failure().step, GetParam());
  EXPECT_EQ(server.failure().component, "fluid");
  EXPECT_EQ(server.join(), ExitCode::solver_failed);
}

INSTANTIATE_TEST_SUITE_P(Steps, FaultyFluid, testing::Values(3, 4));

TEST(Server, CheckpointThatCannotBeWrittenIsToldAndTheSolverGoesOn) {
  int exchanges = 0;
  MemoryServer server(counting_component(exchanges));
  server.configure(one_sphere_in_water());
  server.ask(moving_at(0));
  server.header.step = 1;
  EXPECT_EQ(server.ask(MessageKind::save, session::CheckpointPath{"/full/disk"}), MessageKind::saved);
  session::Saved saved;
  server.decoder.read(saved);
  EXPECT_EQ(saved.problem, "No room for /full/disk (quota). Free some.");
  EXPECT_EQ(server.ask(moving_at(1)), MessageKind::loads);
  EXPECT_EQ(exchanges, 2);
  EXPECT_EQ(server.ask(MessageKind::finish), MessageKind::finished);
  EXPECT_EQ(server.join(), ExitCode::finished);
}

TEST(Server, WhateverRestoreThrowsIsAStateThatCannotBeRead) {
  int exchanges = 0;
  MemoryServer server(counting_component(exchanges));
  server.configure(one_sphere_in_water());
  EXPECT_EQ(server.ask(MessageKind::restore, session::CheckpointPath{"/some/file"}), MessageKind::failure);
  EXPECT_NE(server.failure().reason.find("cannot read the state in /some/file (no step in it)"), std::string::npos);
  EXPECT_EQ(server.join(), ExitCode::storage_failed);
}

TEST(Server, WithoutCheckpointsRefusesToSave) {
  int exchanges = 0;
  FluidComponent component = counting_component(exchanges);
  component.capabilities.features.clear();
  MemoryServer server(component);
  server.configure(one_sphere_in_water());
  server.ask(moving_at(0));
  server.header.step = 1;
  EXPECT_EQ(server.ask(MessageKind::save, session::CheckpointPath{"/some/file"}), MessageKind::failure);
  EXPECT_EQ(server.join(), ExitCode::refused);
}

TEST(Server, FailingConstructionOfTheSolverIsReportedWithItsReason) {
  const FluidComponent component = {{}, [](const FluidSetup&, SolverContext&) -> std::unique_ptr<FluidSolver> {
                                      throw CaseError("The domain is empty (0 cells). Enlarge it.");
                                    }};
  MemoryServer server(component);
  server.welcome();
  EXPECT_EQ(server.ask(one_sphere_in_water()), MessageKind::failure);
  EXPECT_EQ(server.failure().reason, "The domain is empty (0 cells). Enlarge it.");
  EXPECT_EQ(server.join(), ExitCode::bad_case);
}

TEST(Server, RefusalEndsWith65) {
  MemoryServer server(doubles::constant_drag_component());
  EXPECT_EQ(server.receive(), MessageKind::hello);
  server.send(session::Refusal{"not you"});
  EXPECT_EQ(server.join(), ExitCode::refused);
}

TEST(Server, HelloIsRepeatedUntilTheDeadlineWhenNobodyAnswers) {
  MemoryServer server(doubles::constant_drag_component(), 1.2);
  EXPECT_EQ(server.receive(), MessageKind::hello);
  EXPECT_EQ(server.receive(), MessageKind::hello);
  EXPECT_EQ(server.join(), ExitCode::deadline_passed);
}

TEST(Server, StopRequestEndsAWaitingComponentWithItsCode) {
  MemoryServer server(doubles::constant_drag_component());
  server.welcome();
  server.context.request_stop(static_cast<int>(ExitCode::component_lost));
  EXPECT_EQ(server.join(), ExitCode::component_lost);
}

}  // namespace
}  // namespace copepod::component
