#pragma once

#include <set>
#include <string>
#include <vector>

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"
#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod::coupler {

/// Step of a lattice with the given relaxation time [s].
///   Δt = c_s² (τ − 1/2) Δx² / ν,   c_s² = 1/3        [docs/theory.md]
double step_from_relaxation_time(double relaxation_time, double cell_size_m, double viscosity_m2_per_s);
/// Its inverse: τ = 1/2 + ν Δt / (c_s² Δx²).
double relaxation_time_from_step(double step_s, double cell_size_m, double viscosity_m2_per_s);

/// @param field_directory  absolute path of the run directory
FluidSetup make_fluid_setup(const Case& the_case, const Assembly& assembly,
                            const std::string& field_directory);
BodySetup make_body_setup(const Case& the_case, const Assembly& assembly);

/// Features that a case requires of its components: those of the setup (contract/features.hpp) and those of
/// the run.
std::set<std::string> required_of_fluid(const Case& the_case, const Assembly& assembly);
std::set<std::string> required_of_body(const Case& the_case, const Assembly& assembly);

/// What the user has to know about a component: required features that it neglects, and announced names that
/// are not features.
/// @throws Refused naming the features that the component lacks
std::vector<std::string> require_features(const Capabilities& capabilities,
                                          const std::set<std::string>& required);

/// Cells that are computed: the whole domain, halved for every symmetry plane; 0 without a lattice.
std::int64_t computed_cells(const FluidCase& fluid);
/// 19 populations per computed cell [bytes].
std::int64_t population_bytes(const FluidCase& fluid);

}  // namespace copepod::coupler
