#include "config/checks/checks.hpp"
#include "config/sections/case.hpp"

namespace copepod::coupler {
namespace {

bool on_lattice(const Case& the_case) { return the_case.fluid.solver == FluidSolverChoice::lattice_boltzmann; }

const char* time_key(const Case& the_case) {
  return the_case.fluid.relaxation_time ? "fluid.relaxation_time" : "step_s";
}

}  // namespace

void check_time(const Case& the_case, Problems& problems) {
  const bool both = the_case.fluid.relaxation_time && the_case.given_step_s;
  if (both || (!the_case.fluid.relaxation_time && !the_case.given_step_s)) {
    problems.error(both ? "step_s" : "fluid.relaxation_time",
                   std::string("the case gives ") +
                       (both ? "both fluid.relaxation_time and step_s" : "neither fluid.relaxation_time nor step_s") +
                       " (one follows from the other). Give exactly one.");
    return;
  }
  const FluidCase& fluid = the_case.fluid;
  if (fluid.relaxation_time && (fluid.cell_size_m == 0.0 || fluid.kinematic_viscosity_m2_per_s == 0.0)) {
    problems.error("fluid.relaxation_time",
                   "fluid.relaxation_time alone gives no step (it follows with the viscosity and the cell). "
                   "Give fluid.kinematic_viscosity_m2_per_s and fluid.cell_size_m, or step_s instead.");
    return;
  }
  if (!fluid.relaxation_time && !on_lattice(the_case)) return;
  const double tau = relaxation_time_from_step(the_case.step_s, the_case.fluid.cell_size_m,
                                               the_case.fluid.kinematic_viscosity_m2_per_s);
  const std::string found =
      std::string("relaxation_time ") + rounded_text(the_case.fluid.relaxation_time.value_or(tau));
  if (!(tau > 0.5)) {
    problems.error(time_key(the_case), found +
                                           " (it must exceed 1/2: viscosity is proportional to the excess). "
                                           "Use a value such as 0.6667.");
  } else if (!on_lattice(the_case)) {
    return;
  } else if (the_case.fluid.collision == CollisionKind::bgk && tau < 0.52) {
    problems.error(time_key(the_case),
                   found + " (bgk is unstable below about 0.52). Use collision: trt or a larger cell.");
  } else if (tau > 2.0) {
    problems.warning(time_key(the_case), found +
                                             " (bounce-back walls shift noticeably above about 2, most with bgk). "
                                             "Use a smaller step or a larger cell.");
  }
}

void check_domain(const Case& the_case, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const BoundaryKind low = fluid.boundaries[2 * axis].kind;
    const BoundaryKind high = fluid.boundaries[2 * axis + 1].kind;
    if ((low == BoundaryKind::periodic) != (high == BoundaryKind::periodic)) {
      const std::size_t other = 2 * axis + (low == BoundaryKind::periodic ? 1 : 0);
      problems.error(face_path(other), face_path(other) + " is " +
                                           name_of(boundary_names, fluid.boundaries[other].kind) +
                                           " but the opposite face is periodic (what leaves there must come in here). "
                                           "Make both periodic or neither.");
    }
  }
  if (!on_lattice(the_case)) return;
  constexpr std::int64_t most_cells = std::int64_t{1} << 40;
  double cells = 1.0;
  for (const std::int64_t count : fluid.domain_cells) cells *= static_cast<double>(count);
  if (cells > static_cast<double>(most_cells)) {
    problems.error("fluid.domain_cells", "fluid.domain_cells are " + rounded_text(cells) +
                                             " cells in all (no machine holds them). Use fewer or larger cells.");
    return;
  }
}

}  // namespace copepod::coupler
