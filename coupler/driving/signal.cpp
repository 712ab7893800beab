#include "driving/signal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace copepod::coupler {
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

double table_value(const Signal& signal, std::int64_t step, double node) {
  const std::vector<Signal::Point>& table = signal.table;
  const auto period = static_cast<double>(signal.period_steps);
  const double first_steps = table.front().time_steps;
  double time_steps = static_cast<double>(step) - signal.lag_steps + node;
  if (signal.period_steps > 0) {
    const double since_first = within_period(signal, step, signal.lag_steps + first_steps) + node;
    time_steps = first_steps + (since_first < period ? since_first : since_first - period);
  }
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
    case SignalKind::square: {
      const double x = turns(signal, step, 0.5);
      return x - std::floor(x) < 0.5 ? 1.0 : -1.0;
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
  return (5.0 * (value_of(signal, step, 0.5 - off_middle) + value_of(signal, step, 0.5 + off_middle)) +
          8.0 * value_of(signal, step, 0.5)) /
         18.0;
}

}  // namespace copepod::coupler
