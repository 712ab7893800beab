#pragma once

#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"

namespace copepod::coupler {

/// What keeps the coupling of a light body with a lattice fluid stable; masses in those of the fluid displaced.
struct VirtualMassRule {
  double needed_below = 0.0;                      ///< lighter bodies need a virtual mass
  double virtual_mass = 0.0;                      ///< that suffices for a body without any mass
  LoadAveraging averaging = LoadAveraging::none;  ///< of the loads of bodies with a virtual mass
};

/// The rule, fitted to the stability limits that follow from the measured response of a sphere's load to a step in its
/// velocity or angular velocity [docs/decisions/virtual_mass.md]:
///   needed below  max(1.4, 1.65 τ^(3/2)) / r   with averaged loads,   max(2.8/(τ − 1/2), 1.65 τ^(3/2)) / r   without
///   τ < 0.75, averaged loads:      m = min(1.5, 0.62 + 8.8 (τ − 1/2)) / r, with bgk 3.4 / r; parabolic
///                                  boundaries, whose loads do not alternate: the first of these, loads as they are
///   otherwise, loads as they are:  m = 1.2 / (r (τ − 1/2)) + 21 (τ − 1/2) / r²
/// @param radius_cells  r; of a capsule, too, whose load per displaced mass is smaller than that of the sphere
/// @param averaging     that of the case
VirtualMassRule virtual_mass_rule(double radius_cells, double relaxation_time, LoadAveraging averaging,
                                  const FluidCase& fluid);

/// Virtual masses of all bodies, as the case gives them or by the rule.
struct VirtualMasses {
  std::vector<double> mass_kg;                    ///< 0 for bodies whose motion no load changes
  LoadAveraging averaging = LoadAveraging::none;  ///< of the loads of bodies that have one
  bool returns = true;                            ///< whether the coupling makes up for them [VirtualMass]
};
VirtualMasses virtual_masses(const Case& the_case, const Assembly& assembly);

/// Time in which a sphere in Stokes flow loses its momentum, by its mass over 6πμr [s].
double damping_time_s(const BodySpecification& body, const FluidCase& fluid);

/// Free in at least one direction.
bool moves_under_loads(const BodySpecification& body);

/// Mass of a body by that of the fluid it displaces.
double mass_ratio(const BodySpecification& body, const FluidCase& fluid);

/// The rule for a body of the case, with four times the virtual mass where only that keeps its rotation stable.
/// @param body  in a lattice fluid
VirtualMassRule virtual_mass_rule(const BodySpecification& body, const Case& the_case);

}  // namespace copepod::coupler
