#include "driving/signal.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace copepod::coupler {
namespace {

constexpr double pi = std::numbers::pi;

Signal wave(SignalKind kind, std::int64_t period_steps, double lag_steps = 0.0) {
  Signal signal;
  signal.kind = kind;
  signal.amplitude = 3.0;
  signal.period_steps = period_steps;
  signal.lag_steps = lag_steps;
  signal.rise = 0.125;
  return signal;
}

TEST(Signal, IsASineThatIsExactAtQuarterTurns) {
  const Signal sine = wave(SignalKind::sinusoid, 400, 100);
  EXPECT_EQ(value_of(sine, 0, 0.0), -3.0);
  EXPECT_EQ(value_of(sine, 100, 0.0), 0.0);
  EXPECT_EQ(value_of(sine, 200, 0.0), 3.0);
  EXPECT_EQ(value_of(sine, 199, 1.0), 3.0);
  EXPECT_EQ(value_of(sine, 300, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(value_of(sine, 117, 0.5), 3.0 * std::sin(2 * pi * 17.5 / 400));
  EXPECT_NEAR(value_of(wave(SignalKind::sinusoid, 400, -0.25), 10, 0.5), 3.0 * std::sin(2 * pi * 10.75 / 400), 1e-15);
}

TEST(Signal, RepeatsItsBitsInEveryPeriod) {
  for (const SignalKind kind : {SignalKind::sinusoid, SignalKind::square, SignalKind::trapezoid, SignalKind::table}) {
    Signal signal = wave(kind, 1237, 17.3);
    signal.table = {{0, 1}, {300.5, 7}, {1000, -2}};
    for (const std::int64_t step : {0LL, 5LL, 100LL, 700LL, 1236LL}) {
      for (const double node : {0.0, 0.5, 1.0}) {
        EXPECT_EQ(value_of(signal, step, node), value_of(signal, step + 1237LL * 1'000'000, node));
        EXPECT_EQ(value_of(signal, step, node), value_of(signal, step + 1237LL * 1'000'000'000'000, node));
      }
    }
  }
}

TEST(Signal, OfASquareJumpsBetweenSteps) {
  const Signal square = wave(SignalKind::square, 10);
  for (const double node : {0.0, 0.5, 1.0}) {
    EXPECT_EQ(value_of(square, 0, node), 3.0);
    EXPECT_EQ(value_of(square, 4, node), 3.0);
    EXPECT_EQ(value_of(square, 5, node), -3.0);
    EXPECT_EQ(value_of(square, 9, node), -3.0);
    EXPECT_EQ(value_of(square, 10, node), 3.0);
  }
}

TEST(Signal, OfATrapezoidRisesHoldsAndFalls) {
  const Signal trapezoid = wave(SignalKind::trapezoid, 80);  // rises within 10 steps
  EXPECT_EQ(value_of(trapezoid, 0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(value_of(trapezoid, 5, 0.0), 1.5);
  EXPECT_EQ(value_of(trapezoid, 10, 0.0), 3.0);
  EXPECT_EQ(value_of(trapezoid, 30, 0.0), 3.0);
  EXPECT_DOUBLE_EQ(value_of(trapezoid, 34, 0.5), 1.65);
  EXPECT_EQ(value_of(trapezoid, 40, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(value_of(trapezoid, 45, 0.0), -1.5);
  EXPECT_EQ(value_of(trapezoid, 60, 0.0), -3.0);
  EXPECT_DOUBLE_EQ(value_of(trapezoid, 75, 0.0), -1.5);
}

TEST(Signal, OfATableIsLinearBetweenItsPoints) {
  Signal table = wave(SignalKind::table, 0, 2);
  table.amplitude = 2.0;
  table.table = {{10, 1}, {20, 3}, {30, -1}};
  EXPECT_EQ(value_of(table, 0, 0.0), 2.0);
  EXPECT_EQ(value_of(table, 12, 0.0), 2.0);
  EXPECT_DOUBLE_EQ(value_of(table, 17, 0.0), 4.0);
  EXPECT_DOUBLE_EQ(value_of(table, 26, 0.5), 2.0 * (3.0 - 4.0 * 0.45));
  EXPECT_EQ(value_of(table, 32, 0.0), -2.0);
  EXPECT_EQ(value_of(table, 1000, 0.0), -2.0);
  table.lag_steps = 0.0;
  table.period_steps = 40;
  EXPECT_DOUBLE_EQ(value_of(table, 35, 0.0), -1.0);  // from −1 at 30 to 1 at 50
  EXPECT_DOUBLE_EQ(value_of(table, 45, 0.0), 1.0);
  EXPECT_DOUBLE_EQ(value_of(table, 55, 0.0), 4.0);
}

TEST(Signal, OfATableRepeatsFromItsFirstPointOn) {
  Signal table = wave(SignalKind::table, 0, 100);
  table.amplitude = 1.0;
  table.period_steps = 100;
  table.lag_steps = 0.3;
  table.table = {{0, 0}, {50, 1}};
  EXPECT_NEAR(value_of(table, 0, 1.0), 0.7 / 50.0, 1e-14);  // the node passes the end of the period
  table.table = {{0, 0}, {1, 5}, {50, 1}};
  EXPECT_NEAR(value_of(table, 100, 1.0), 3.5, 1e-12);
  table.lag_steps = 0.0;
  table.table = {{-30, 0}, {20, 1}};
  EXPECT_DOUBLE_EQ(value_of(table, 90, 0.0), 0.4);
  table.table = {{250, 0}, {300, 1}};
  EXPECT_DOUBLE_EQ(value_of(table, 60, 0.0), 0.2);
}

TEST(Signal, ActsInWholeStepsOfItsWindow) {
  Signal constant;
  constant.amplitude = 1.0;
  constant.start_step = 2;
  constant.stop_step = 4;
  for (std::int64_t step = 0; step < 6; ++step) {
    const double expected = step >= 2 && step < 4 ? 1.0 : 0.0;
    EXPECT_EQ(value_of(constant, step, 0.0), expected) << step;
    EXPECT_EQ(value_of(constant, step, 1.0), expected) << step;
  }
}

TEST(Signal, RampsUpFromItsStart) {
  Signal constant;
  constant.amplitude = 4.0;
  constant.start_step = 10;
  constant.ramp_steps = 8;
  EXPECT_EQ(value_of(constant, 9, 0.0), 0.0);
  EXPECT_EQ(value_of(constant, 10, 0.0), 0.0);
  EXPECT_EQ(value_of(constant, 13, 0.5), 1.75);
  EXPECT_EQ(value_of(constant, 18, 0.0), 4.0);
  EXPECT_EQ(value_of(constant, 1000, 0.0), 4.0);
}

TEST(Signal, IsIntegratedOverAStep) {
  Signal ramped;
  ramped.amplitude = 4.0;
  ramped.ramp_steps = 8;
  ramped.start_step = 10;
  EXPECT_EQ(integral_over_step(ramped, 9), 0.0);
  EXPECT_NEAR(integral_over_step(ramped, 13), 1.75, 1e-15);
  const Signal square = wave(SignalKind::square, 100);
  EXPECT_NEAR(integral_over_step(square, 40), value_of(square, 40, 0.5), 1e-14);
  const Signal sinusoid = wave(SignalKind::sinusoid, 20);
  const double exact = sinusoid.amplitude * 20.0 / (2.0 * std::numbers::pi) * (1.0 - std::cos(0.1 * std::numbers::pi));
  EXPECT_NEAR(integral_over_step(sinusoid, 0) / exact, 1.0, 1e-9);
}

TEST(SineOfTurns, IsExactAtQuarterTurns) {
  EXPECT_EQ(sine_of_turns(0.0), 0.0);
  EXPECT_EQ(sine_of_turns(0.25), 1.0);
  EXPECT_EQ(sine_of_turns(0.5), 0.0);
  EXPECT_EQ(sine_of_turns(0.75), -1.0);
  EXPECT_EQ(sine_of_turns(1.0), 0.0);
  EXPECT_DOUBLE_EQ(sine_of_turns(0.4), std::sin(0.8 * std::numbers::pi));
}

}  // namespace
}  // namespace copepod::coupler
