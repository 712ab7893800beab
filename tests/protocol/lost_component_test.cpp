#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "coupled_run.hpp"

namespace copepod::protocol_test {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A fluid that halts in the exchange of a step, reporting progress, and never continues.
class HaltedFluid {
 public:
  explicit HaltedFluid(int step) : step_(step) {}
  [[nodiscard]] std::vector<std::string> options() const {
    return {"--halt-in", "exchange", "--halt-at-step", std::to_string(step_), "--halt-file", file_};
  }
  /// Returns once it halts.
  void wait() const {
    while (!std::filesystem::exists(file_)) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }

 private:
  int step_;
  TemporaryFolder folder_;
  std::string file_ = folder_.path("halted");
};

LinkSettings with_silence(double silence_s) {
  LinkSettings settings;
  settings.silence_s = silence_s;
  return settings;
}

LinkSettings with_progress_deadline(double deadline_s) {
  LinkSettings settings;
  settings.progress_deadline_s = deadline_s;
  return settings;
}

TEST(LostComponent, KilledFluidIsReportedByName) {
  CoupledRun run({"--slow-ms", "20"}, {});
  run.begin();
  run.advance(3);
  run.fluid_process->signal(SIGKILL);
  const std::string reason = run.advance_until_failure();
  EXPECT_TRUE(contains(reason, "The fluid component on host ")) << reason;
  EXPECT_TRUE(contains(reason, "at step 3 is gone")) << reason;
}

TEST(LostComponent, ABrokenConnectionMayComeBackForATenthOfTheSilenceLimit) {
  CoupledRun run({"--slow-ms", "20"}, {}, with_silence(15.0));
  run.begin();
  run.advance(3);
  run.fluid_process->signal(SIGKILL);
  const auto start = Clock::now();
  const std::string reason = run.advance_until_failure();
  EXPECT_GT(seconds_since(start), 1.4);
  EXPECT_TRUE(contains(reason, "is gone")) << reason;
}

TEST(LostComponent, KilledBodyIsNoticedWhileTheCouplerWaitsForTheFluid) {
  const HaltedFluid halted(5);
  CoupledRun run(halted.options(), {});
  run.begin();
  run.advance(5);
  std::thread killer([&] {
    halted.wait();
    run.body_process->signal(SIGKILL);
  });
  const std::string reason = run.advance_until_failure();
  killer.join();
  EXPECT_TRUE(contains(reason, "The body component on host ")) << reason;
  EXPECT_TRUE(contains(reason, "is gone")) << reason;
}

TEST(LostComponent, FrozenFluidIsReportedAfterTheSilenceLimit) {
  CoupledRun run({}, {}, with_silence(1.0));
  run.begin();
  run.advance(3);
  run.fluid_process->signal(SIGSTOP);
  const auto start = Clock::now();
  const std::string reason = run.advance_until_failure();
  EXPECT_GT(seconds_since(start), 0.9);
  EXPECT_TRUE(contains(reason, "is frozen")) << reason;
}

TEST(LostComponent, HangingSolverIsReportedThoughItAnswersPings) {
  CoupledRun run({"--hang-at-step", "4"}, {}, with_progress_deadline(1.5));
  run.begin();
  const auto start = Clock::now();
  const std::string reason = run.advance_until_failure();
  EXPECT_GT(seconds_since(start), 1.4);
  EXPECT_TRUE(contains(reason, "The fluid component")) << reason;
  EXPECT_TRUE(contains(reason, "at step 4 hangs")) << reason;
}

TEST(LostComponent, SlowStepThatProgressesIsNeverKilled) {
  CoupledRun run({"--slow-ms", "2500", "--reports-progress"}, {}, with_progress_deadline(1.0));
  run.begin();
  EXPECT_NO_THROW(run.advance(2));
}

TEST(LostComponent, SlowStepWithoutProgressIsTakenForAHang) {
  CoupledRun run({"--slow-ms", "2500"}, {}, with_progress_deadline(1.0));
  run.begin();
  EXPECT_THROW(run.advance(2), ComponentLost);
}

TEST(LostComponent, FailingSolverIsReportedWithItsRankStepAndReason) {
  CoupledRun run({"--throw-at-step", "6"}, {});
  run.begin();
  try {
    run.advance(10);
    FAIL() << "the failure was lost";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().component, "fluid");
    EXPECT_EQ(failure.report().rank, 3);
    EXPECT_EQ(failure.report().step, 6);
    EXPECT_EQ(failure.code(), ExitCode::solver_failed);
    EXPECT_TRUE(contains(failure.what(), "The flow diverged")) << failure.what();
  }
  EXPECT_EQ(run.fluid_process->wait(), 70);
}

TEST(LostComponent, FailureOfTheBulkUpdateArrivesThoughTheReplyWasSent) {
  CoupledRun run({"--throw-in-advance-of-step", "2"}, {});
  run.begin();
  try {
    run.advance(10);
    FAIL() << "the failure was lost";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().step, 2);
    EXPECT_EQ(failure.report().rank, 1);
    EXPECT_TRUE(contains(failure.what(), "bulk update")) << failure.what();
  }
}

TEST(LostComponent, MissingComponentIsNamedWhenTheDeadlineIsOver) {
  LinkSettings settings;
  settings.connect_deadline_s = 1.0;
  const TemporaryFolder elsewhere;
  CoupledRun run({}, {}, settings, "", {.body_endpoint = "ipc://" + elsewhere.path("absent.ipc")});
  while (!contains(run.fluid_log(), "connects to")) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  try {
    run.link->await_components();
    FAIL() << "the loss was not detected";
  } catch (const DeadlinePassed& error) {
    EXPECT_TRUE(contains(error.what(), "The body component did not connect")) << error.what();
  }
}

TEST(LostComponent, StopSignalEndsAWait) {
  std::atomic<int> stop{0};
  LinkSettings settings;
  settings.stop_signal = [&] { return stop.load(); };
  const HaltedFluid halted(2);
  CoupledRun run(halted.options(), {}, settings);
  run.begin();
  run.advance(2);
  std::thread stopper([&] {
    halted.wait();
    stop = SIGINT;
  });
  EXPECT_THROW(run.advance(1), Interrupted);
  stopper.join();
}

TEST(LostCoupler, AbortEndsBothComponentsWithItsCode) {
  CoupledRun run({"--slow-ms", "60000"}, {});
  run.begin();
  run.advance(1);
  run.link->abort({ExitCode::interrupted, "coupler", "here", 0, 2, "The test stops the run."});
  EXPECT_EQ(run.body_process->wait(), 130);
  EXPECT_EQ(run.fluid_process->wait(), 130) << "a solver that does not react is ended after two seconds";
  EXPECT_TRUE(contains(run.fluid_log(), "The test stops the run.")) << run.fluid_log();
}

TEST(LostCoupler, ComponentsEndThemselvesWhenItsConnectionBreaks) {
  CoupledRun run({}, {});
  run.begin();
  run.advance(2);
  run.end_coupler();
  EXPECT_EQ(run.fluid_process->wait(), 69);
  EXPECT_EQ(run.body_process->wait(), 69);
}

TEST(LostCoupler, ComponentEndsItselfWhenPingsStayAway) {
  CoupledRun run({"--orphan-after", "1.5"}, {});
  run.begin();
  const auto start = Clock::now();
  EXPECT_EQ(run.fluid_process->wait(), 69);  // no pings, since no call waits on the link
  EXPECT_GT(seconds_since(start), 1.0);
  EXPECT_TRUE(contains(run.fluid_log(), "The coupler is silent")) << run.fluid_log();
}

TEST(LostCoupler, IsNotSuspectedWhileItWaitsForALateComponent) {
  CoupledRun run({}, {});
  run.body_process->signal(SIGSTOP);
  std::thread late([&run] {
    std::this_thread::sleep_for(std::chrono::seconds(5));
    run.body_process->signal(SIGCONT);
  });
  EXPECT_NO_THROW(run.begin());
  late.join();
  EXPECT_NO_THROW(run.advance(2));
}

TEST(LostCoupler, IsNotSuspectedWhileItDoesSomethingElse) {
  CoupledRun run({"--orphan-after", "1"}, {"--orphan-after", "1"});
  run.begin();
  run.advance(2);
  run.link->stay_in_touch_during([] { std::this_thread::sleep_for(std::chrono::milliseconds(2500)); });
  EXPECT_NO_THROW(run.advance(2));
  EXPECT_THROW(run.link->stay_in_touch_during([] { throw StorageError("the disk is full"); }), StorageError);
}

TEST(LostCoupler, ComponentGivesUpWhenNoCouplerComes) {
  const TemporaryFolder folder;
  ChildProcess fluid(fake_fluid_command("ipc://" + folder.path("absent.ipc"), {"--connect-deadline", "1"}));
  EXPECT_EQ(fluid.wait(), 74);
}

}  // namespace
}  // namespace copepod::protocol_test
