#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "integration/integration.hpp"
#include "model/vector_loops.hpp"

namespace copepod::body {

namespace {

/// to = start + factor · rate, for the first `bodies` columns.
void extrapolate(const BlockState& start, Eigen::Index bodies, double factor, const BlockState& rate, BlockState& to) {
  const auto extrapolate_part = [&](const auto& from, const auto& change, auto& target) {
    target.leftCols(bodies) = from.leftCols(bodies) + factor * change.leftCols(bodies);
  };
  for_each_part(extrapolate_part, start, rate, to);
}

/// The same, and sum += weight · rate.
void accumulate_and_extrapolate(BlockState& sum, double weight, const BlockState& start, Eigen::Index bodies,
                                double factor, const BlockState& rate, BlockState& to) {
  const auto accumulate_part = [&](auto& total, const auto& from, const auto& change, auto& target) {
    for (Eigen::Index i = 0; i < total.rows(); ++i)
      body::accumulate_and_extrapolate(bodies, weight, factor, &from(i, 0), &change(i, 0), &total(i, 0), &target(i, 0));
  };
  for_each_part(accumulate_part, sum, start, rate, to);
}

/// to += factor · (a + b), for the first `bodies` columns.
void add_scaled_sum(Eigen::Index bodies, double factor, const BlockState& a, const BlockState& b, BlockState& to) {
  const auto add_part = [&](const auto& one, const auto& other, auto& target) {
    for (Eigen::Index i = 0; i < target.rows(); ++i)
      body::add_scaled_sum(bodies, factor, &one(i, 0), &other(i, 0), &target(i, 0));
  };
  for_each_part(add_part, a, b, to);
}

/// Semi-implicit Euler, the paper's integrator: velocities with the loads at the start of the step, positions
/// with the new velocities.
///   v' = v + h F/m,   x' = x + h v',   L' = L + h τ,   q' = exp(h ω(q, L')/2) ⊗ q              (B14), (B15)
/// First order; symplectic for forces that depend on positions alone.
void advance_by_semi_implicit_euler(const EquationsOfMotion& equations, const BodyBlock& block,
                                    const AppliedLoads& applied, double step_s, IntegratorWork& work) {
  const Eigen::Index bodies = block.bodies;
  equations.begin(block, applied, work.equations);
  equations.evaluate(block, applied, 0, work.state, work.rate, work.equations);

  BlockState& end = work.state;
  end.velocity_m_per_s.leftCols(bodies) += step_s * work.rate.velocity_m_per_s.leftCols(bodies);
  end.position_m.leftCols(bodies) += step_s * end.velocity_m_per_s.leftCols(bodies);
  end.angular_momentum_N_m_s.leftCols(bodies) += step_s * work.rate.angular_momentum_N_m_s.leftCols(bodies);
  equations.model().angular_velocities_rad_per_s(block, end, work.equations.angular_velocity_rad_per_s);
  for (Eigen::Index i = 0; i < bodies; ++i) {
    const Eigen::Vector3d w_WB = work.equations.angular_velocity_rad_per_s.col(i);
    end.orientation_wxyz.col(i) = rotated(step_s * w_WB, end.orientation_wxyz.col(i));
  }
  normalise_orientations(bodies, components(end.orientation_wxyz));
}

/// Classical Runge-Kutta method of fourth order for y = (x, q, v, L):
///   k₁ = f(t, y), k₂ = f(t + h/2, y + h/2 k₁), k₃ = f(t + h/2, y + h/2 k₂), k₄ = f(t + h, y + h k₃)
///   y' = y + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)                                                     (B16)
/// Loads of the fluid are constant over the step; driving forces are sampled at 0, 1/2 and 1 of it. Why this
/// method: docs/decisions/body_integrator.md.
void advance_by_runge_kutta_4(const EquationsOfMotion& equations, const BodyBlock& block, const AppliedLoads& applied,
                              double step_s, IntegratorWork& work) {
  constexpr Eigen::Index start = 0;
  constexpr Eigen::Index middle = 1;
  constexpr Eigen::Index end = 2;
  const double h = step_s;
  const auto evaluate = [&](Eigen::Index node, const BlockState& at, BlockState& rate) {
    equations.evaluate(block, applied, node, at, rate, work.equations);
  };

  equations.begin(block, applied, work.equations);
  evaluate(start, work.state, work.rate_sum);  // k₁

  extrapolate(work.state, block.bodies, 0.5 * h, work.rate_sum, work.stage);
  evaluate(middle, work.stage, work.rate);  // k₂
  accumulate_and_extrapolate(work.rate_sum, 2.0, work.state, block.bodies, 0.5 * h, work.rate, work.stage);
  evaluate(middle, work.stage, work.rate);  // k₃
  accumulate_and_extrapolate(work.rate_sum, 2.0, work.state, block.bodies, h, work.rate, work.stage);
  evaluate(end, work.stage, work.rate);  // k₄
  add_scaled_sum(block.bodies, h / 6.0, work.rate_sum, work.rate, work.state);
  normalise_orientations(block.bodies, components(work.state.orientation_wxyz));
}

}  // namespace

std::vector<double> driving_nodes(Integrator kind) {
  switch (kind) {
    case Integrator::semi_implicit_euler:
      return {0.0};
    case Integrator::runge_kutta_4:
      return {0.0, 0.5, 1.0};
  }
  throw CaseError("unknown integrator (the setup holds no valid value). Use semi_implicit_euler or runge_kutta_4.");
}

void advance(Integrator kind, const EquationsOfMotion& equations, const BodyBlock& block, const AppliedLoads& applied,
             double step_s, IntegratorWork& work) {
  const auto advance_by = kind == Integrator::runge_kutta_4 ? advance_by_runge_kutta_4 : advance_by_semi_implicit_euler;
  advance_by(equations, block, applied, step_s, work);
}

}  // namespace copepod::body
