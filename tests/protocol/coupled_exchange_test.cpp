#include <chrono>
#include <cmath>
#include <filesystem>
#include <iostream>

#include <gtest/gtest.h>

#include "coupled_run.hpp"

namespace copepod::protocol_test {
namespace {

/// v(n) = v(0) (1 − decay)^n, as FreePointBody and ConstantDragFluid compute it.
void expect_closed_form(const Kinematics& kinematics, int steps) {
  const double expected = 1e-3 * std::pow(1 - decay_per_step(), steps);
  EXPECT_NEAR(kinematics.velocity_m_per_s(0, 0), expected, 1e-12 * expected * steps);
  EXPECT_EQ(kinematics.velocity_m_per_s.col(1).norm(), 0.0);
  EXPECT_EQ(kinematics.step, steps);
}

TEST(CoupledExchange, OverIpcFollowsTheClosedForm) {
  CoupledRun run({}, {});
  run.begin();
  run.advance(500);
  expect_closed_form(run.kinematics, 500);
  run.link->finish();
  EXPECT_EQ(run.fluid_process->wait(), 0);
  EXPECT_EQ(run.body_process->wait(), 0);
}

TEST(CoupledExchange, OverTcpFollowsTheClosedForm) {
  CoupledRun run({}, {}, {}, tcp_endpoint());
  run.begin();
  run.advance(200);
  expect_closed_form(run.kinematics, 200);
  run.link->finish();
  EXPECT_EQ(run.fluid_process->wait(), 0);
  EXPECT_EQ(run.body_process->wait(), 0);
}

TEST(CoupledExchange, TellsWhatTheComponentsCanDo) {
  CoupledRun run({}, {});
  run.link->await_components();
  EXPECT_EQ(run.link->capabilities(coupler::kFluid).name, "constant drag");
  EXPECT_TRUE(run.link->capabilities(coupler::kFluid).features.contains("solver:external"));
  EXPECT_TRUE(run.link->capabilities(coupler::kBody).features.contains("motion:free"));
}

TEST(CoupledExchange, ReturnsTheSummariesOfBothSolvers) {
  CoupledRun run({}, {});
  run.begin();
  run.advance(10);
  EXPECT_EQ(run.fluid->summarise().cell_updates, 10U);
  EXPECT_NE(run.fluid->summarise().digest, 0U);
  EXPECT_EQ(run.body->summarise().ranks, 1);
}

TEST(CoupledExchange, ContinuesFromCheckpointsBitForBit) {
  CoupledRun first({}, {});
  first.begin();
  first.advance(10);
  first.fluid->save(first.folder.path("fluid.checkpoint"));
  first.body->save(first.folder.path("body.checkpoint"));
  first.advance(10);

  CoupledRun second({}, {});
  second.link->await_components();
  second.fluid = std::make_unique<RemoteFluid>(*second.link, two_spheres_in_fluid(), 10);
  second.body = std::make_unique<RemoteBody>(*second.link, two_free_spheres(), 10);
  second.fluid->restore(first.folder.path("fluid.checkpoint"));
  second.body->restore(first.folder.path("body.checkpoint"));
  second.body->kinematics(second.kinematics);
  second.kinematics.step = 10;
  second.advance(10);

  EXPECT_EQ(second.kinematics.step, 20);
  EXPECT_EQ(second.fluid->summarise().digest, first.fluid->summarise().digest);
  EXPECT_EQ(second.body->summarise().digest, first.body->summarise().digest);
}

TEST(CoupledExchange, RefusesAStepOutOfOrderAndNamesBothSteps) {
  CoupledRun run({}, {});
  run.begin();
  run.advance(3);
  run.kinematics.step = 7;
  try {
    run.fluid->exchange(run.kinematics, run.loads);
    FAIL() << "step 7 after step 2 was taken";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.code(), ExitCode::refused);
    EXPECT_NE(std::string(failure.what()).find("step 7"), std::string::npos) << failure.what();
    EXPECT_NE(std::string(failure.what()).find("step 3"), std::string::npos) << failure.what();
  }
  EXPECT_EQ(run.fluid_process->wait(), 65);
}

}  // namespace
}  // namespace copepod::protocol_test
