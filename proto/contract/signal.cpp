#include "contract/signal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace copepod {

namespace {

/// (step − lag) mod T, in [0, T].
double within_period(const Signal& signal, std::int64_t step, double lag_steps) {
  const auto period = static_cast<double>(signal.period_steps);
  const double since = std::fmod(static_cast<double>(step % signal.period_steps) - lag_steps, period);
  return since < 0.0 ? since + period : since;
}

double turns(const Signal& signal, std::int64_t step, double node) {
  return (within_period(signal, step, signal.lag_steps) + node) / static_cast<double>(signal.period_steps);
}

double interpolated(const Signal::Point& before, const Signal::Point& after, double time_steps) {
  return std::lerp(before.value, after.value,
                   (time_steps - before.time_steps) / (after.time_steps - before.time_steps));
}

/// Where in a table a step starts; of one that repeats within a period of its first point.
double table_time(const Signal& signal, std::int64_t step) {
  if (signal.period_steps == 0) return static_cast<double>(step) - signal.lag_steps;
  const double first_steps = signal.table.front().time_steps;
  return first_steps + within_period(signal, step, signal.lag_steps + first_steps);
}

double table_value(const Signal& signal, std::int64_t step, double node) {
  const std::vector<Signal::Point>& table = signal.table;
  const auto period = static_cast<double>(signal.period_steps);
  double time_steps = table_time(signal, step) + node;
  if (signal.period_steps > 0 && time_steps >= table.front().time_steps + period) time_steps -= period;
  const auto after = std::upper_bound(table.begin(), table.end(), time_steps,
                                      [](double time, const Signal::Point& point) { return time < point.time_steps; });
  if (after != table.begin() && after != table.end()) return interpolated(*(after - 1), *after, time_steps);
  if (signal.period_steps == 0) return (after == table.begin() ? table.front() : table.back()).value;
  return interpolated(table.back(), {table.front().time_steps + period, table.front().value}, time_steps);
}

double wave(const Signal& signal, std::int64_t step, double node) {
  switch (signal.kind) {
    case SignalKind::constant:
      break;
    case SignalKind::sinusoid:
      return sine_of_turns(turns(signal, step, node));
    case SignalKind::square: {  // its mean over the step: twice the part above zero, less 1
      const auto period = static_cast<double>(signal.period_steps);
      const double half = 0.5 * period, from = within_period(signal, step, signal.lag_steps);
      return 2.0 * (std::clamp(half - from, 0.0, 1.0) + std::clamp(from + 1.0 - period, 0.0, half)) - 1.0;
    }
    case SignalKind::trapezoid: {
      const double x = turns(signal, step, node) + 0.25;
      const double from_crest = std::abs(2.0 * (x - std::floor(x)) - 1.0);  // 0 at the crest, 1 at the trough
      return std::clamp((0.25 - 0.5 * from_crest) / signal.rise, -1.0, 1.0);
    }
    case SignalKind::table:
      return table_value(signal, step, node);
  }
  return 1.0;
}

/// Parts of a step in which a signal is smooth: fractions of it, from 0 to 1. A sinusoid is cut into parts short enough
/// for the rule below.
std::vector<double> smooth_parts(const Signal& signal, std::int64_t step) {
  const auto period = static_cast<double>(signal.period_steps);
  std::vector<double> ends{0.0};
  const auto add_corners = [&](std::span<const Signal::Point> corners, double start_steps) {
    const auto add_after = [&](double from) {
      for (auto at = std::ranges::upper_bound(corners, from, {}, &Signal::Point::time_steps);
           at != corners.end() && at->time_steps < from + 1.0; ++at)
        ends.push_back(at->time_steps - from);
    };
    add_after(start_steps);
    if (period > 0.0) add_after(start_steps - period);  // the next period may begin within the step
  };
  if (signal.kind == SignalKind::sinusoid) {
    constexpr double parts_in_period = 128.0;
    const double parts = std::ceil(parts_in_period / period);
    for (double part = 1.0; part < parts; part += 1.0) ends.push_back(part / parts);
  } else if (signal.kind == SignalKind::trapezoid) {
    const double rise = signal.rise * period;
    add_corners(std::array<Signal::Point, 4>{{{rise}, {0.5 * period - rise}, {0.5 * period + rise}, {period - rise}}},
                within_period(signal, step, signal.lag_steps));
  } else if (signal.kind == SignalKind::table) {
    add_corners(signal.table, table_time(signal, step));
  }
  ends.push_back(1.0);
  return ends;
}

}  // namespace

double sine_of_turns(double turns) {
  double x = turns - std::floor(turns);
  double sign = 1.0;
  if (x >= 0.5) {
    x -= 0.5;
    sign = -1.0;
  }
  if (x > 0.25) x = 0.5 - x;
  return sign * std::sin(2.0 * std::numbers::pi * x);
}

double value_of(const Signal& signal, std::int64_t step, double node) {
  if (step < signal.start_step || step >= signal.stop_step) return 0.0;
  const double since_start = static_cast<double>(step - signal.start_step) + node;
  const double ramp = signal.ramp_steps > 0 ? std::min(1.0, since_start / static_cast<double>(signal.ramp_steps)) : 1.0;
  return ramp * signal.amplitude * wave(signal, step, node);
}

double integral_over_step(const Signal& signal, std::int64_t step) {
  constexpr double off_middle = 0.38729833462074168852;  // √0.6 / 2
  const std::vector<double> ends = smooth_parts(signal, step);
  double sum = 0.0;
  for (std::size_t part = 1; part < ends.size(); ++part) {
    const double length = ends[part] - ends[part - 1], middle = 0.5 * (ends[part - 1] + ends[part]);
    const auto value = [&](double off) { return value_of(signal, step, middle + off * length); };
    sum += length * (5.0 * (value(-off_middle) + value(off_middle)) + 8.0 * value(0.0)) / 18.0;
  }
  return sum;
}

std::pair<double, double> range_of(const Signal& signal) {
  if (signal.kind == SignalKind::constant) return std::minmax({0.0, signal.amplitude});
  if (signal.kind != SignalKind::table) return {-std::abs(signal.amplitude), std::abs(signal.amplitude)};
  std::pair<double, double> range;
  for (const Signal::Point& point : signal.table) {
    range.first = std::min(range.first, signal.amplitude * point.value);
    range.second = std::max(range.second, signal.amplitude * point.value);
  }
  return range;
}

double largest_magnitude(const Signal& signal) {
  const auto [least, greatest] = range_of(signal);
  return std::max(-least, greatest);
}

}  // namespace copepod
