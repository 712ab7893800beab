#pragma once

#include <cstddef>
#include <vector>

#include "contract/body_setup.hpp"

namespace copepod::coupler {

/// Longest step with which an integrator of ours does not amplify an oscillation ẍ = −a x − b ẋ [s].
///   semi-implicit Euler: h² a + 2 h b = 4;   Runge-Kutta 4: |R(h μ)| = 1 with μ² + b μ + a = 0,
///   R(z) = 1 + z + z²/2 + z³/6 + z⁴/24                                           [docs/theory_bodies.md]
/// @param stiffness_per_s2  a ≥ 0
/// @param damping_per_s     b ≥ 0
/// @return infinity where both are 0
double largest_stable_step_s(Integrator integrator, double stiffness_per_s2, double damping_per_s);

/// A spring, bend or joint that limits the step.
struct StepLimit {
  std::size_t spring = 0;       ///< index; bends are counted after the springs, and joints after the bends
  double largest_step_s = 0.0;  ///< infinity where nothing can oscillate
};

/// The springs or bends that limit the step most.
struct FastestSprings {
  StepLimit together;  ///< with all of them; perhaps somewhat longer steps are stable, too
  StepLimit alone;     ///< as if each spring or bend were the only one: longer steps never are
};

/// Bounds of the fastest mode of a network of springs, bends and the springs of joints, in its first position.
/// The squares of the modes' angular frequencies are the eigenvalues of M = √K G √K. K holds the stiffnesses, and G_ef
/// is the acceleration by which a unit tension of spring f stretches spring e: 1/m_A + 1/m_B for f = e. For bends, read
/// moment for tension and angle for stretch, and so for hinges. The largest eigenvalue lies between two bounds:
///   max_e M_ee  (each spring alone)  ≤  largest eigenvalue  ≤  max_e Σ_f |M_ef|  (all together)
/// For two bodies both are exact, for three in a row the upper one. The damping is bounded likewise. Neglected:
/// stiffness across a spring under tension, the fluid that moves with a body, and joints, which make modes slower.
/// @param springs, bends, joints  those with a body below 0 are left out, but for joints with the world
FastestSprings fastest_springs(const std::vector<BodySpecification>& bodies,
                               const std::vector<SpringSpecification>& springs,
                               const std::vector<BendSpecification>& bends,
                               const std::vector<JointSpecification>& joints, Integrator integrator);

}  // namespace copepod::coupler
