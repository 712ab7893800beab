#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <thread>

#include <gtest/gtest.h>

#include "coupled_run.hpp"
#include "fake_programs.hpp"

namespace copepod::protocol_test {
namespace {

std::vector<std::string> python_program(const std::string& script) {
  setenv("PYTHONPATH", kPythonPath, 1);
  return {kPython, kPythonExamples + script};
}

Programs both_in_python() { return {python_program("stokes_drag_fluid.py"), python_program("point_masses.py")}; }

TEST(PythonComponent, BothRolesFollowTheClosedForm) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.begin();
  run.advance(50);
  const double expected = 1e-3 * std::pow(1 - decay_per_step(), 50);
  EXPECT_NEAR(run.kinematics.velocity_m_per_s(0, 0), expected, 1e-10 * expected);
  EXPECT_EQ(run.kinematics.step, 50);
  EXPECT_EQ(run.fluid->summarise().digest, 50U);
  run.link->finish();
  EXPECT_EQ(run.fluid_process->wait(), 0);
  EXPECT_EQ(run.body_process->wait(), 0);
}

TEST(PythonComponent, ContinuesFromACheckpoint) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.begin();
  run.advance(3);
  run.body->save(run.folder.path("body.checkpoint"));
  const std::uint64_t digest = run.body->summarise().digest;

  CoupledRun next({}, {}, {}, "", both_in_python());
  next.link->await_components();
  next.body = std::make_unique<RemoteBody>(*next.link, two_free_spheres(), 3);
  next.body->restore(run.folder.path("body.checkpoint"));
  EXPECT_EQ(next.body->summarise().digest, digest);
}

TEST(PythonComponent, RefusesAStepOutOfOrderWithTheSameWordsAsC) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.begin();
  run.kinematics.step = 7;
  try {
    run.fluid->exchange(run.kinematics, run.loads);
    FAIL() << "step 7 was taken where step 0 was due";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.code(), ExitCode::refused);
    EXPECT_EQ(std::string(failure.what()),
              "Kinematics of step 7 came where step 0 was due (a step was left out or done twice). Advance "
              "step by step.");
  }
  EXPECT_EQ(run.fluid_process->wait(), 65);
}

TEST(PythonComponent, ReportsAnExceptionOfItsSolver) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.link->await_components();
  BodySetup falling = two_free_spheres();
  falling.gravity_m_per_s2 = {0, 0, -9.81};
  try {
    RemoteBody body(*run.link, falling, 0);
    FAIL() << "gravity was taken";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().component, "body");
    EXPECT_NE(std::string(failure.what()).find("these point masses neglect"), std::string::npos) << failure.what();
  }
  EXPECT_EQ(run.body_process->wait(), 70);
}

TEST(PythonComponent, EndsItselfWhenTheCouplerIsGone) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.begin();
  run.advance(2);
  run.end_coupler();
  EXPECT_EQ(run.fluid_process->wait(), 69);
  EXPECT_EQ(run.body_process->wait(), 69);
}

TEST(PythonComponent, WaitsForAComponentThatStartsMuchLater) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.body_process->signal(SIGSTOP);
  std::thread late([&run] {
    std::this_thread::sleep_for(std::chrono::seconds(5));  // longer than a broken connection is put up with
    run.body_process->signal(SIGCONT);
  });
  EXPECT_NO_THROW(run.begin());
  late.join();
  EXPECT_NO_THROW(run.advance(2));
}

TEST(PythonComponent, ObeysAnAbort) {
  CoupledRun run({}, {}, {}, "", both_in_python());
  run.begin();
  run.link->abort({ExitCode::solver_failed, "coupler", "here", 0, 2, "The other one failed."});
  EXPECT_EQ(run.fluid_process->wait(), 70);
  EXPECT_EQ(run.body_process->wait(), 70);
}

}  // namespace
}  // namespace copepod::protocol_test
