#pragma once

#include "integration/time_integrator.hpp"

namespace copepod::body {

/// Classical Runge-Kutta method of fourth order for y = (x, q, v, L):
///   k₁ = f(t, y), k₂ = f(t + h/2, y + h/2 k₁), k₃ = f(t + h/2, y + h/2 k₂), k₄ = f(t + h, y + h k₃)
///   y' = y + h/6 (k₁ + 2 k₂ + 2 k₃ + k₄)                                                     (B16)
/// Loads of the fluid are constant over the step; driving forces are sampled at 0, 1/2 and 1 of it. Why this
/// method: docs/decisions/body_integrator.md.
class RungeKutta4 final : public TimeIntegrator {
 public:
  RungeKutta4(EquationsOfMotion& equations, double step_s);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0, 0.5, 1.0}; }
  void advance(const BodyBlock& block, const AppliedLoads& applied, MotionState& state) override;

 private:
  EquationsOfMotion& equations_;
  double step_s_;
  MotionState stage_;
  MotionState rate_;
  MotionState rate_sum_;
};

}  // namespace copepod::body
