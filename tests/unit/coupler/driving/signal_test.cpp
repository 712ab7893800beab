#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "driving/driving_protocol.hpp"

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
  EXPECT_NEAR(integral_over_step(sinusoid, 0) / exact, 1.0, 1e-14);
}

TEST(Signal, OfASquareHasTheMeanZeroInEveryPeriodWithAnyLag) {
  for (const std::int64_t period : {20, 21, 37}) {
    for (const double lag_steps : {0.0, 0.3, 5.25, 10.5, -3.9}) {
      const Signal square = wave(SignalKind::square, period, lag_steps);
      double sum = 0.0;
      for (std::int64_t step = 0; step < period; ++step) sum += value_of(square, step, 0.0);
      EXPECT_NEAR(sum, 0.0, 1e-12) << period << " " << lag_steps;
    }
  }
}

/// w(t); of a square the mean over the step, from its integral, a triangle wave.
long double ideal(const Signal& signal, long double t) {
  if (signal.kind == SignalKind::constant) return 1;
  const auto period = static_cast<long double>(signal.period_steps);
  if (signal.kind == SignalKind::square) {
    const auto triangle = [&](long double at) {
      const long double x = (at - signal.lag_steps) / period;
      return period * std::min(x - std::floor(x), std::ceil(x) - x);
    };
    return triangle(std::floor(t) + 1) - triangle(std::floor(t));
  }
  if (signal.kind == SignalKind::table) {
    const auto& points = signal.table;
    t -= signal.lag_steps;
    if (period > 0) {
      while (t < points.front().time_steps) t += period;
      while (t >= points.front().time_steps + period) t -= period;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool last = i + 1 == points.size();
      if (last && period == 0) break;
      const long double t_0 = points[i].time_steps, v_0 = points[i].value;
      const long double t_1 = last ? points[0].time_steps + period : points[i + 1].time_steps;
      const long double v_1 = last ? points[0].value : points[i + 1].value;
      if (t >= t_0 && t < t_1) return v_0 + (v_1 - v_0) * (t - t_0) / (t_1 - t_0);
    }
    return t < points.front().time_steps ? points.front().value : points.back().value;
  }
  long double x = (t - signal.lag_steps) / period;
  x -= std::floor(x);
  if (signal.kind == SignalKind::sinusoid) return std::sin(2 * std::numbers::pi_v<long double> * x);
  const long double to_zero = std::min({x, std::abs(x - 0.5L), 1 - x});  // in turns
  return (x < 0.5L ? 1 : -1) * std::min(1.0L, to_zero / signal.rise);
}

/// ∫₀ⁿ A r w dt: Milne's open rule between all corners of w, where r w is a parabola; of a sinusoid in many parts.
long double ideal_integral(const Signal& signal, std::int64_t steps) {
  std::vector<long double> ends{0, static_cast<long double>(steps)};
  const auto add = [&](long double t) {
    if (t > 0 && t < static_cast<long double>(steps)) ends.push_back(t);
  };
  const auto period = static_cast<long double>(signal.period_steps);
  add(static_cast<long double>(signal.start_step));
  add(static_cast<long double>(signal.start_step + signal.ramp_steps));
  if (signal.stop_step < steps) add(static_cast<long double>(signal.stop_step));
  for (std::int64_t step = 0; signal.kind == SignalKind::square && step < steps; ++step)
    add(static_cast<long double>(step));
  const long double repetitions = period > 0 ? std::ceil((steps + 100 + std::abs(signal.lag_steps)) / period) : 0;
  for (long double n = -repetitions; n <= repetitions; n += 1) {
    for (const Signal::Point& point : signal.table) add(n * period + point.time_steps + signal.lag_steps);
    if (period == 0) continue;
    for (const long double x : {0.0L + signal.rise, 0.5L - signal.rise, 0.5L + signal.rise, 1.0L - signal.rise})
      add((n + x) * period + signal.lag_steps);
    if (signal.kind != SignalKind::sinusoid) continue;
    for (int part = 0; part < 2048; ++part) add((n + part / 2048.0L) * period + signal.lag_steps);
  }
  std::ranges::sort(ends);
  long double sum = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const long double from = ends[i - 1], length = ends[i] - from;
    if (length < 1e-15L) continue;
    const auto value = [&](long double at) -> long double {
      const long double t = from + length * at;
      if (t < signal.start_step || t >= signal.stop_step) return 0;
      const long double since = t - signal.start_step;
      const long double r = signal.ramp_steps > 0 ? std::min(1.0L, since / signal.ramp_steps) : 1.0L;
      return signal.amplitude * r * ideal(signal, t);
    };
    sum += length * (2 * value(0.25L) - value(0.5L) + 2 * value(0.75L)) / 3;
  }
  return sum;
}

TEST(Signal, IsIntegratedExactlyForEveryKindPeriodLagRampStartAndStop) {
  std::mt19937 random(28);
  const auto uniform = [&random](double low, double high) {
    return low + (high - low) * (static_cast<double>(random()) / 4294967296.0);
  };
  const auto whole = [&](double low, double high) { return static_cast<std::int64_t>(uniform(low, high)); };
  for (int sample = 0; sample < 500; ++sample) {
    Signal signal = wave(static_cast<SignalKind>(sample % 5), whole(1, 90), random() % 2 ? uniform(-200, 200) : 7.0);
    signal.rise = random() % 4 ? uniform(0.01, 0.25) : 0.25;
    if (signal.kind == SignalKind::constant || (signal.kind == SignalKind::table && random() % 2))
      signal.period_steps = 0;
    signal.start_step = random() % 2 ? whole(0, 100) : 0;
    signal.ramp_steps = random() % 2 ? whole(0, 100) : 0;
    if (random() % 2) signal.stop_step = signal.start_step + whole(1, 200);
    if (signal.kind == SignalKind::table) {
      double time_steps = uniform(-50, 50);
      const double room = signal.period_steps > 0 ? static_cast<double>(signal.period_steps) / 7.0 : 9.0;
      for (int point = 0; point < 7; ++point, time_steps += uniform(0.01, 1.0) * room)
        signal.table.push_back({time_steps, uniform(-2, 2)});
    }
    double sum = 0.0;
    const std::int64_t steps = 250;
    for (std::int64_t step = 0; step < steps; ++step) sum += integral_over_step(signal, step);
    const auto exact = static_cast<double>(ideal_integral(signal, steps));
    EXPECT_NEAR(sum, exact, 1e-12 * std::max(signal.amplitude, std::abs(exact)))
        << "kind " << sample % 5 << ", period " << signal.period_steps << ", lag " << signal.lag_steps;
  }
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
