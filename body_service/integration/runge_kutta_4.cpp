#include "integration/runge_kutta_4.hpp"

#include "integration/state_arithmetic.hpp"

namespace copepod::body {

RungeKutta4::RungeKutta4(EquationsOfMotion& equations, double step_s)
    : equations_(equations), step_s_(step_s) {
  for (MotionState* work : {&stage_, &rate_, &rate_sum_}) work->resize(equations.longest_block());
}

void RungeKutta4::advance(const BodyBlock& block, const AppliedLoads& applied, MotionState& state) {
  constexpr Eigen::Index start = 0;
  constexpr Eigen::Index middle = 1;
  constexpr Eigen::Index end = 2;
  const double h = step_s_;

  copy_block(state, block, stage_);
  equations_.evaluate(block, applied, start, stage_, rate_sum_);  // k₁

  extrapolate(state, block, 0.5 * h, rate_sum_, stage_);
  equations_.evaluate(block, applied, middle, stage_, rate_);  // k₂
  accumulate(rate_sum_, block.bodies, 2.0, rate_);

  extrapolate(state, block, 0.5 * h, rate_, stage_);
  equations_.evaluate(block, applied, middle, stage_, rate_);  // k₃
  accumulate(rate_sum_, block.bodies, 2.0, rate_);

  extrapolate(state, block, h, rate_, stage_);
  equations_.evaluate(block, applied, end, stage_, rate_);  // k₄
  accumulate(rate_sum_, block.bodies, 1.0, rate_);

  advance_block(state, block, h / 6.0, rate_sum_);
  normalise_orientations(block, state);
}

}  // namespace copepod::body
