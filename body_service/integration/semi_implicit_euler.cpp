#include "integration/semi_implicit_euler.hpp"

#include "integration/state_arithmetic.hpp"
#include "model/rotation.hpp"

namespace copepod::body {

SemiImplicitEuler::SemiImplicitEuler(EquationsOfMotion& equations, double step_s)
    : equations_(equations), step_s_(step_s) {
  start_.resize(equations.longest_block());
  rate_.resize(equations.longest_block());
}

void SemiImplicitEuler::advance(const BodyBlock& block, const AppliedLoads& applied, MotionState& state) {
  const Eigen::Index bodies = block.bodies;
  copy_block(state, block, start_);
  equations_.evaluate(block, applied, 0, start_, rate_);

  auto velocity = state.velocity_m_per_s.middleCols(block.first, bodies);
  velocity += step_s_ * rate_.velocity_m_per_s.leftCols(bodies);
  state.position_m.middleCols(block.first, bodies) += step_s_ * velocity;
  state.angular_momentum_N_m_s.middleCols(block.first, bodies) +=
      step_s_ * rate_.angular_momentum_N_m_s.leftCols(bodies);
  for (Eigen::Index i = 0; i < bodies; ++i) {
    const Eigen::Index body = block.first + i;
    const Eigen::Vector4d q_WB = start_.orientation_wxyz.col(i);
    const Eigen::Vector3d w_WB =
        equations_.model().angular_velocity_rad_per_s(body, q_WB, state.angular_momentum_N_m_s.col(body));
    state.orientation_wxyz.col(body) = rotated(step_s_ * w_WB, q_WB);
  }
  normalise_orientations(block, state);
}

}  // namespace copepod::body
