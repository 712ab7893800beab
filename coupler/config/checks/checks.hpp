#pragma once

#include <cstddef>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "contract/body_setup.hpp"

namespace copepod::coupler {

// What can be known about a case before it runs. Each check reports to `problems` with the key it is about.

void check_time(const Case& the_case, Problems& problems);    ///< step, relaxation time
void check_domain(const Case& the_case, Problems& problems);  ///< cells, faces
/// What comes with the choice of solvers: a command, a plane, output that only some have.
void check_solvers(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_symmetry(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_names(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_bodies(const Case& the_case, const Assembly& assembly, Problems& problems);  ///< walls, overlaps
/// Springs, bends and pair forces.
void check_springs(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_joints(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_stiffness(const Case& the_case, const Assembly& assembly, Problems& problems);  ///< of springs
/// Errors of loads and of motions that the combination of schemes is known for.
void check_schemes(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_light_bodies(const Case& the_case, const Assembly& assembly, Problems& problems);  ///< for the coupling
/// Forces on the fluid that bodies do not feel, and those on both that nothing takes up.
void check_mixture(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_contact(const Case& the_case, const Assembly& assembly, Problems& problems);  ///< stiffness, walls

/// All of them; a check whose sections hold errors already is left out, its values mean nothing.
void check_case(const Case& the_case, const Assembly& assembly, Problems& problems);

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

/// What keeps the coupling of a light body with a lattice fluid stable; masses in those of the fluid displaced.
struct VirtualMassRule {
  double needed_below = 0.0;                      ///< lighter bodies need a virtual mass
  double virtual_mass = 0.0;                      ///< that suffices for a body without any mass
  LoadAveraging averaging = LoadAveraging::none;  ///< of the loads of bodies with a virtual mass
};

/// Virtual masses of all bodies, as the case gives them or by the rule.
struct VirtualMasses {
  std::vector<double> mass_kg;                    ///< 0 for bodies whose motion no load changes
  LoadAveraging averaging = LoadAveraging::none;  ///< of the loads of bodies that have one
  bool returns = true;                            ///< whether the coupling makes up for them [VirtualMass]
};
VirtualMasses virtual_masses(const Case& the_case, const Assembly& assembly);

/// Free in at least one direction.
bool moves_under_loads(const BodySpecification& body);

/// Mass of the fluid that a body displaces; 0 in vacuum.
double displaced_kg(const BodySpecification& body, const FluidCase& fluid);

/// Mass of a body by that of the fluid it displaces; the same of its inertia about an axis if that is less.
double mass_ratio(const BodySpecification& body, const FluidCase& fluid);

/// The rule for a body of the case, with four times the virtual mass where only that keeps its rotation stable.
/// @param body  in a lattice fluid
VirtualMassRule virtual_mass_rule(const BodySpecification& body, const Case& the_case);

}  // namespace copepod::coupler
