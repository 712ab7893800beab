#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

namespace copepod {

/// Form of a signal; `value_of` has the equations.
enum class SignalKind { constant, sinusoid, square, trapezoid, table };

/// A quantity that varies in time, zero outside the steps [start, stop):
///   A r(t) w(x),   r = min(1, (t − start)/ramp),   x = (t − lag)/T in turns, t in steps        (C16)
struct Signal {
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();  ///< as `stop_step`

  struct Point {
    double time_steps = 0.0;  ///< since step 0
    double value = 0.0;       ///< in units of the amplitude
    bool operator==(const Point&) const = default;
  };  ///< of a table

  SignalKind kind = SignalKind::constant;  ///< form of w(x)
  double amplitude = 0.0;                  ///< A, in the unit of what it drives: [N], [N m] or [m]; none of a factor
  std::int64_t period_steps = 0;           ///< T; 0 for constants and for tables that do not repeat
  double lag_steps = 0.0;                  ///< whole or not
  double rise = 0.0;                       ///< of a trapezoid: turns from 0 to A, in (0, 1/4]
  std::int64_t ramp_steps = 0;             ///< 0: none
  std::int64_t start_step = 0;             ///< first step that has a value
  std::int64_t stop_step = never;          ///< first step that no longer has one
  std::vector<Point> table;                ///< ascending in time
  bool operator==(const Signal&) const = default;
};

/// Value at the time step + node.
///   sinusoid: w = sin 2πx;  square: ±1 in the two halves of a period;  trapezoid: 0 to 1 within `rise`, and so on;
///   table: linear between its points; it repeats with its period, or holds its first and last value.
/// Whole periods are taken off in integers, so that the phase of the millionth step is as exact as that of the first.
/// A signal starts, stops and jumps between steps, never inside one: a square has in each step its mean over that step,
/// so that whole periods of any number of steps and any lag cancel.
/// @param node  fraction of the step
double value_of(const Signal& signal, std::int64_t step, double node);

/// Integral over one step, in units of the amplitude times a step, exact to rounding: by Gauss's three-point rule for
/// each part between two corners.
double integral_over_step(const Signal& signal, std::int64_t step);

/// Its least and greatest value, 0 included.
std::pair<double, double> range_of(const Signal& signal);
double largest_magnitude(const Signal& signal);  ///< its greatest magnitude

/// sin(2πx) of a number of turns, exact at quarter turns.
double sine_of_turns(double turns);

}  // namespace copepod
