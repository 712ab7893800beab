#pragma once

#include "config/sections/case.hpp"
#include "config/sections/expand.hpp"
#include "config/yaml/document.hpp"

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
void check_signals(const Case& the_case, const Assembly& assembly, Problems& problems);
void check_strokes(const Case& the_case, Problems& problems);
void check_velocities(const Case& the_case, const Assembly& assembly, Problems& problems);  ///< Mach number
void check_output(const Case& the_case, Problems& problems);
void check_services(const Case& the_case, Problems& problems);  ///< what can run in one process

/// All of them; a check whose sections hold errors already is left out, its values mean nothing.
void check_case(const Case& the_case, const Assembly& assembly, Problems& problems);

}  // namespace copepod::coupler
