#include "integration/time_integrator.hpp"

#include <cmath>

#include "contract/errors.hpp"
#include "geometry/rotation.hpp"

namespace copepod::body {

namespace {

/// Calls apply(part) for each of the four parts of a state, `part` a pointer to the member.
template <class Apply>
void for_each_part(const Apply& apply) {
  apply(&MotionState::position_m);
  apply(&MotionState::orientation_wxyz);
  apply(&MotionState::velocity_m_per_s);
  apply(&MotionState::angular_momentum_N_m_s);
}

/// Copies the columns of a block to the front of a work array.
void copy_block(const MotionState& state, const BodyBlock& block, MotionState& work) {
  for_each_part(
      [&](auto part) { (work.*part).leftCols(block.bodies) = (state.*part).middleCols(block.first, block.bodies); });
}

/// work = state + factor · rate, for the columns of a block; `work` and `rate` begin with its first body.
void extrapolate(const MotionState& state, const BodyBlock& block, double factor, const MotionState& rate,
                 MotionState& work) {
  for_each_part([&](auto part) {
    (work.*part).leftCols(block.bodies) =
        (state.*part).middleCols(block.first, block.bodies) + factor * (rate.*part).leftCols(block.bodies);
  });
}

/// sum += factor · rate, for `bodies` columns of the sum from `first` on; `rate` begins with that body.
void accumulate(MotionState& sum, Eigen::Index first, Eigen::Index bodies, double factor, const MotionState& rate) {
  for_each_part([&](auto part) { (sum.*part).middleCols(first, bodies) += factor * (rate.*part).leftCols(bodies); });
}

/// Brings the quaternions of a block back to unit length, from which a step leaves them by its error.
void normalise_orientations(const BodyBlock& block, MotionState& state) {
  // Within rounding of unit length nothing is gained, and a body that does not turn must keep its bits.
  constexpr double rounding = 2e-15;
  for (Eigen::Index body = block.first; body < block.first + block.bodies; ++body) {
    const double squared_norm = state.orientation_wxyz.col(body).squaredNorm();
    if (std::abs(squared_norm - 1.0) > rounding) state.orientation_wxyz.col(body) *= 1.0 / std::sqrt(squared_norm);
  }
}

/// Semi-implicit Euler, the paper's integrator: velocities with the loads at the start of the step, positions
/// with the new velocities.
///   v' = v + h F/m,   x' = x + h v',   L' = L + h τ,   q' = exp(h ω(q, L')/2) ⊗ q              (B14), (B15)
/// First order; symplectic for forces that depend on positions alone.
class SemiImplicitEuler final : public TimeIntegrator {
 public:
  explicit SemiImplicitEuler(EquationsOfMotion& equations) : equations_(equations) {
    start_.resize(equations.longest_block());
    rate_.resize(equations.longest_block());
  }

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }

  void advance(const BodyBlock& block, const AppliedLoads& applied, double step_s, MotionState& state) override {
    const Eigen::Index bodies = block.bodies;
    copy_block(state, block, start_);
    equations_.evaluate(block, applied, 0, start_, rate_);

    auto velocity = state.velocity_m_per_s.middleCols(block.first, bodies);
    velocity += step_s * rate_.velocity_m_per_s.leftCols(bodies);
    state.position_m.middleCols(block.first, bodies) += step_s * velocity;
    state.angular_momentum_N_m_s.middleCols(block.first, bodies) +=
        step_s * rate_.angular_momentum_N_m_s.leftCols(bodies);
    for (Eigen::Index i = 0; i < bodies; ++i) {
      const Eigen::Index body = block.first + i;
      const Eigen::Vector4d q_WB = start_.orientation_wxyz.col(i);
      const Eigen::Vector3d w_WB =
          equations_.model().angular_velocity_rad_per_s(body, q_WB, state.angular_momentum_N_m_s.col(body));
      state.orientation_wxyz.col(body) = rotated(step_s * w_WB, q_WB);
    }
    normalise_orientations(block, state);
  }

 private:
  EquationsOfMotion& equations_;
  MotionState start_;
  MotionState rate_;
};

/// Classical Runge-Kutta method of fourth order for y = (x, q, v, L):
///   k₁ = f(t, y), k₂ = f(t + h/2, y + h/2 k₁), k₃ = f(t + h/2, y + h/2 k₂), k₄ = f(t + h, y + h k₃)
///   y' = y + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)                                                     (B16)
/// Loads of the fluid are constant over the step; driving forces are sampled at 0, 1/2 and 1 of it. Why this
/// method: docs/decisions/body_integrator.md.
class RungeKutta4 final : public TimeIntegrator {
 public:
  explicit RungeKutta4(EquationsOfMotion& equations) : equations_(equations) {
    for (MotionState* work : {&stage_, &rate_, &rate_sum_}) work->resize(equations.longest_block());
  }

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0, 0.5, 1.0}; }

  void advance(const BodyBlock& block, const AppliedLoads& applied, double step_s, MotionState& state) override {
    constexpr Eigen::Index start = 0;
    constexpr Eigen::Index middle = 1;
    constexpr Eigen::Index end = 2;
    const double h = step_s;

    copy_block(state, block, stage_);
    equations_.evaluate(block, applied, start, stage_, rate_sum_);  // k₁

    extrapolate(state, block, 0.5 * h, rate_sum_, stage_);
    equations_.evaluate(block, applied, middle, stage_, rate_);  // k₂
    accumulate(rate_sum_, 0, block.bodies, 2.0, rate_);

    extrapolate(state, block, 0.5 * h, rate_, stage_);
    equations_.evaluate(block, applied, middle, stage_, rate_);  // k₃
    accumulate(rate_sum_, 0, block.bodies, 2.0, rate_);

    extrapolate(state, block, h, rate_, stage_);
    equations_.evaluate(block, applied, end, stage_, rate_);  // k₄
    accumulate(rate_sum_, 0, block.bodies, 1.0, rate_);

    accumulate(state, block.first, block.bodies, h / 6.0, rate_sum_);
    normalise_orientations(block, state);
  }

 private:
  EquationsOfMotion& equations_;
  MotionState stage_;
  MotionState rate_;
  MotionState rate_sum_;
};

}  // namespace

std::unique_ptr<TimeIntegrator> make_time_integrator(Integrator kind, EquationsOfMotion& equations) {
  switch (kind) {
    case Integrator::semi_implicit_euler:
      return std::make_unique<SemiImplicitEuler>(equations);
    case Integrator::runge_kutta_4:
      return std::make_unique<RungeKutta4>(equations);
  }
  throw CaseError("unknown integrator (the setup holds no valid value). Use semi_implicit_euler or runge_kutta_4.");
}

}  // namespace copepod::body
