#pragma once

#include "integration/time_integrator.hpp"

namespace copepod::body {

/// Semi-implicit Euler, the paper's integrator: velocities with the loads at the start of the step, positions
/// with the new velocities.
///   v' = v + h F/m,   x' = x + h v',   L' = L + h τ,   q' = exp(h ω(q, L')/2) ⊗ q              (B14), (B15)
/// First order; symplectic for forces that depend on positions alone.
class SemiImplicitEuler final : public TimeIntegrator {
 public:
  SemiImplicitEuler(EquationsOfMotion& equations, double step_s);

  [[nodiscard]] std::vector<double> driving_nodes() const override { return {0.0}; }
  void advance(const BodyBlock& block, const AppliedLoads& applied, MotionState& state) override;

 private:
  EquationsOfMotion& equations_;
  double step_s_;
  MotionState start_;
  MotionState rate_;
};

}  // namespace copepod::body
