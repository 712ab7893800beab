#include <chrono>
#include <iostream>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "disturbed_run.hpp"
#include "fake_programs.hpp"

namespace copepod::chaos {
namespace {

using protocol_test::digests_of_local_run;

ChaosPlan only(Disturbance kind, double share) {
  ChaosPlan plan;
  plan.kinds = {kind};
  plan.share = share;
  return plan;
}

/// One kind of disturbance at a time.
class Chaos : public testing::TestWithParam<Disturbance> {};

TEST_P(Chaos, OfOneKindChangesNoDigest) {
  constexpr int steps = 100;
  DisturbedRun disturbed(only(GetParam(), GetParam() == Disturbance::cut ? 0.01 : 0.1));
  EXPECT_EQ(disturbed.run(steps), digests_of_local_run(steps));
  EXPECT_EQ(disturbed.coupled->fluid_process->wait(), 0);
  EXPECT_EQ(disturbed.coupled->body_process->wait(), 0);
  std::cout << disturbed.tell_disturbances() << "\n";
}

INSTANTIATE_TEST_SUITE_P(Kinds, Chaos, testing::ValuesIn(kDisturbances),
                         [](const auto& instance) { return std::string(name_of(instance.param)); });

TEST(ChaosOfAllKinds, ChangesNoDigest) {
  constexpr int steps = 300;
  for (const std::uint64_t seed : {1U, 2U}) {
    DisturbedRun disturbed({.seed = seed});
    EXPECT_EQ(disturbed.run(steps), digests_of_local_run(steps)) << "seed " << seed;
    std::cout << disturbed.tell_disturbances() << "\n";
  }
}

TEST(ChaosOfAllKinds, ChangesNothingForComponentsInPython) {
  setenv("PYTHONPATH", protocol_test::kPythonPath, 1);
  const auto python = [](const char* script) {
    return std::vector<std::string>{protocol_test::kPython, std::string(protocol_test::kPythonExamples) + script};
  };
  constexpr int steps = 100;
  protocol_test::CoupledRun undisturbed({}, {}, {}, "", {python("stokes_drag_fluid.py"), python("point_masses.py")});
  undisturbed.begin();
  undisturbed.advance(steps);
  DisturbedRun disturbed({.seed = 3}, DisturbedRun::over_a_network(),
                         {python("stokes_drag_fluid.py"), python("point_masses.py")});
  EXPECT_EQ(disturbed.run(steps), undisturbed.digests());
}

TEST(ChaosWithoutEnd, IsReportedByName) {
  coupler::LinkSettings settings;
  settings.progress_deadline_s = 1.0;
  settings.silence_s = 1.0;
  settings.connect_deadline_s = 2.0;
  const ChaosPlan everything_is_lost = only(Disturbance::corrupt, 1.0);
  DisturbedRun disturbed(everything_is_lost, settings);
  EXPECT_THROW(disturbed.run(1), DeadlinePassed);
}

}  // namespace
}  // namespace copepod::chaos
