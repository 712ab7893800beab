#include "scheme/load_averaging.hpp"

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

Loads loads_of(std::int64_t step, double force) {
  Loads loads;
  loads.step = step;
  loads.resize(2);
  loads.force_N.setConstant(force);
  loads.torque_N_m.setConstant(2.0 * force);
  return loads;
}

TEST(LoadAverage, AveragesTwoStepsAndTheFirstWithItself) {
  LoadAverage average(LoadAveraging::two_step);
  Loads applied;
  average.apply(loads_of(0, 4.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 4.0);
  average.apply(loads_of(1, 8.0), applied);
  EXPECT_EQ(applied.step, 1);
  EXPECT_EQ(applied.force_N(2, 1), 6.0);
  EXPECT_EQ(applied.torque_N_m(1, 0), 12.0);
  average.apply(loads_of(2, 0.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 4.0);
}

TEST(LoadAverage, RemovesAnOscillationFromStepToStep) {
  LoadAverage average(LoadAveraging::two_step);
  Loads applied;
  for (std::int64_t step = 0; step < 10; ++step) {
    average.apply(loads_of(step, step % 2 == 0 ? 1.0 : -1.0), applied);
    EXPECT_EQ(applied.force_N(0, 0), step == 0 ? 1.0 : 0.0);
  }
}

TEST(LoadAverage, PassesLoadsOnUnchangedWhenAskedTo) {
  LoadAverage average(LoadAveraging::none);
  Loads applied;
  average.apply(loads_of(0, 4.0), applied);
  average.apply(loads_of(1, 8.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 8.0);
  EXPECT_EQ(applied.step, 1);
}

TEST(LoadAverage, ContinuesWhereARestoredOneStopped) {
  LoadAverage one(LoadAveraging::two_step);
  Loads applied;
  one.apply(loads_of(0, 3.0), applied);
  LoadAverage other(LoadAveraging::two_step);
  other.restore(one.previous());
  other.apply(loads_of(1, 5.0), applied);
  EXPECT_EQ(applied.force_N(0, 0), 4.0);
}

}  // namespace
}  // namespace copepod::coupler
