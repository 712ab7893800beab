#pragma once

#include <cmath>

#include "model/body_block.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Copies the columns of a block to the front of a work array.
inline void copy_block(const MotionState& state, const BodyBlock& block, MotionState& work) {
  const auto first = block.first;
  const auto n = block.bodies;
  work.position_m.leftCols(n) = state.position_m.middleCols(first, n);
  work.orientation_wxyz.leftCols(n) = state.orientation_wxyz.middleCols(first, n);
  work.velocity_m_per_s.leftCols(n) = state.velocity_m_per_s.middleCols(first, n);
  work.angular_momentum_N_m_s.leftCols(n) = state.angular_momentum_N_m_s.middleCols(first, n);
}

/// work = state + factor · rate, for the columns of a block; `work` and `rate` begin with its first body.
inline void extrapolate(const MotionState& state, const BodyBlock& block, double factor,
                        const MotionState& rate, MotionState& work) {
  const auto first = block.first;
  const auto n = block.bodies;
  work.position_m.leftCols(n) = state.position_m.middleCols(first, n) + factor * rate.position_m.leftCols(n);
  work.orientation_wxyz.leftCols(n) =
      state.orientation_wxyz.middleCols(first, n) + factor * rate.orientation_wxyz.leftCols(n);
  work.velocity_m_per_s.leftCols(n) =
      state.velocity_m_per_s.middleCols(first, n) + factor * rate.velocity_m_per_s.leftCols(n);
  work.angular_momentum_N_m_s.leftCols(n) =
      state.angular_momentum_N_m_s.middleCols(first, n) + factor * rate.angular_momentum_N_m_s.leftCols(n);
}

/// sum += factor · rate, for the first `bodies` columns.
inline void accumulate(MotionState& sum, Eigen::Index bodies, double factor, const MotionState& rate) {
  sum.position_m.leftCols(bodies) += factor * rate.position_m.leftCols(bodies);
  sum.orientation_wxyz.leftCols(bodies) += factor * rate.orientation_wxyz.leftCols(bodies);
  sum.velocity_m_per_s.leftCols(bodies) += factor * rate.velocity_m_per_s.leftCols(bodies);
  sum.angular_momentum_N_m_s.leftCols(bodies) += factor * rate.angular_momentum_N_m_s.leftCols(bodies);
}

/// state += factor · rate, for the columns of a block; `rate` begins with its first body.
inline void advance_block(MotionState& state, const BodyBlock& block, double factor,
                          const MotionState& rate) {
  const auto first = block.first;
  const auto n = block.bodies;
  state.position_m.middleCols(first, n) += factor * rate.position_m.leftCols(n);
  state.orientation_wxyz.middleCols(first, n) += factor * rate.orientation_wxyz.leftCols(n);
  state.velocity_m_per_s.middleCols(first, n) += factor * rate.velocity_m_per_s.leftCols(n);
  state.angular_momentum_N_m_s.middleCols(first, n) += factor * rate.angular_momentum_N_m_s.leftCols(n);
}

/// Brings the quaternions of a block back to unit length, from which a step leaves them by its error.
inline void normalise_orientations(const BodyBlock& block, MotionState& state) {
  // Within rounding of unit length nothing is gained, and a body that does not turn must keep its bits.
  constexpr double rounding = 2e-15;
  for (Eigen::Index body = block.first; body < block.first + block.bodies; ++body) {
    const double squared_norm = state.orientation_wxyz.col(body).squaredNorm();
    if (std::abs(squared_norm - 1.0) > rounding)
      state.orientation_wxyz.col(body) *= 1.0 / std::sqrt(squared_norm);
  }
}

}  // namespace copepod::body
