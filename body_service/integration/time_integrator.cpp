#include "integration/time_integrator.hpp"

#include "contract/errors.hpp"
#include "geometry/rotation.hpp"
#include "model/vector_loops.hpp"

namespace copepod::body {

namespace {

/// Calls apply(part) with pointers to the four members of a state.
template <class Apply>
void for_each_part(const Apply& apply) {
  apply(&BlockState::position_m);
  apply(&BlockState::orientation_wxyz);
  apply(&BlockState::velocity_m_per_s);
  apply(&BlockState::angular_momentum_N_m_s);
}

/// to = start + factor · rate, for the first `bodies` columns.
void extrapolate(const BlockState& start, Eigen::Index bodies, double factor, const BlockState& rate, BlockState& to) {
  for_each_part([&](auto part) {
    (to.*part).leftCols(bodies) = (start.*part).leftCols(bodies) + factor * (rate.*part).leftCols(bodies);
  });
}

/// The same, and sum += weight · rate.
void accumulate_and_extrapolate(BlockState& sum, double weight, const BlockState& start, Eigen::Index bodies,
                                double factor, const BlockState& rate, BlockState& to) {
  for_each_part([&](auto part) {
    for (Eigen::Index i = 0; i < (sum.*part).rows(); ++i) {
      body::accumulate_and_extrapolate(static_cast<std::size_t>(bodies), weight, factor, &(start.*part)(i, 0),
                                       &(rate.*part)(i, 0), &(sum.*part)(i, 0), &(to.*part)(i, 0));
    }
  });
}

/// to += factor · (a + b), for the first `bodies` columns.
void add_scaled_sum(Eigen::Index bodies, double factor, const BlockState& a, const BlockState& b, BlockState& to) {
  for_each_part([&](auto part) {
    for (Eigen::Index i = 0; i < (to.*part).rows(); ++i) {
      body::add_scaled_sum(static_cast<std::size_t>(bodies), factor, &(a.*part)(i, 0), &(b.*part)(i, 0),
                           &(to.*part)(i, 0));
    }
  });
}

/// Semi-implicit Euler, the paper's integrator: velocities with the loads at the start of the step, positions
/// with the new velocities.
///   v' = v + h F/m,   x' = x + h v',   L' = L + h τ,   q' = exp(h ω(q, L')/2) ⊗ q              (B14), (B15)
/// First order; symplectic for forces that depend on positions alone.
class SemiImplicitEuler final : public TimeIntegrator {
 public:
  explicit SemiImplicitEuler(const EquationsOfMotion& equations) : equations_(equations) {}

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }

  void advance(const BodyBlock& block, const AppliedLoads& applied, double step_s, Work& work) const override {
    const Eigen::Index bodies = block.bodies;
    equations_.begin(block, applied, work.equations);
    equations_.evaluate(block, applied, 0, work.state, work.rate, work.equations);

    BlockState& end = work.state;
    end.velocity_m_per_s.leftCols(bodies) += step_s * work.rate.velocity_m_per_s.leftCols(bodies);
    end.position_m.leftCols(bodies) += step_s * end.velocity_m_per_s.leftCols(bodies);
    end.angular_momentum_N_m_s.leftCols(bodies) += step_s * work.rate.angular_momentum_N_m_s.leftCols(bodies);
    equations_.model().angular_velocities_rad_per_s(block, end, work.equations.angular_velocity_rad_per_s);
    for (Eigen::Index i = 0; i < bodies; ++i) {
      const Eigen::Vector3d w_WB = work.equations.angular_velocity_rad_per_s.col(i);
      end.orientation_wxyz.col(i) = rotated(step_s * w_WB, end.orientation_wxyz.col(i));
    }
    normalise_orientations(static_cast<std::size_t>(bodies), components(end.orientation_wxyz));
  }

 private:
  const EquationsOfMotion& equations_;
};

/// Classical Runge-Kutta method of fourth order for y = (x, q, v, L):
///   k₁ = f(t, y), k₂ = f(t + h/2, y + h/2 k₁), k₃ = f(t + h/2, y + h/2 k₂), k₄ = f(t + h, y + h k₃)
///   y' = y + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)                                                     (B16)
/// Loads of the fluid are constant over the step; driving forces are sampled at 0, 1/2 and 1 of it. Why this
/// method: docs/decisions/body_integrator.md.
class RungeKutta4 final : public TimeIntegrator {
 public:
  explicit RungeKutta4(const EquationsOfMotion& equations) : equations_(equations) {}

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0, 0.5, 1.0}; }

  void advance(const BodyBlock& block, const AppliedLoads& applied, double step_s, Work& work) const override {
    constexpr Eigen::Index start = 0;
    constexpr Eigen::Index middle = 1;
    constexpr Eigen::Index end = 2;
    const double h = step_s;
    const auto evaluate = [&](Eigen::Index node, const BlockState& at, BlockState& rate) {
      equations_.evaluate(block, applied, node, at, rate, work.equations);
    };

    equations_.begin(block, applied, work.equations);
    evaluate(start, work.state, work.rate_sum);  // k₁

    extrapolate(work.state, block.bodies, 0.5 * h, work.rate_sum, work.stage);
    evaluate(middle, work.stage, work.rate);  // k₂
    accumulate_and_extrapolate(work.rate_sum, 2.0, work.state, block.bodies, 0.5 * h, work.rate, work.stage);
    evaluate(middle, work.stage, work.rate);  // k₃
    accumulate_and_extrapolate(work.rate_sum, 2.0, work.state, block.bodies, h, work.rate, work.stage);
    evaluate(end, work.stage, work.rate);  // k₄
    add_scaled_sum(block.bodies, h / 6.0, work.rate_sum, work.rate, work.state);
    normalise_orientations(static_cast<std::size_t>(block.bodies), components(work.state.orientation_wxyz));
  }

 private:
  const EquationsOfMotion& equations_;
};

}  // namespace

std::unique_ptr<TimeIntegrator> make_time_integrator(Integrator kind, const EquationsOfMotion& equations) {
  switch (kind) {
    case Integrator::semi_implicit_euler:
      return std::make_unique<SemiImplicitEuler>(equations);
    case Integrator::runge_kutta_4:
      return std::make_unique<RungeKutta4>(equations);
  }
  throw CaseError("unknown integrator (the setup holds no valid value). Use semi_implicit_euler or runge_kutta_4.");
}

}  // namespace copepod::body
