#include "config/setups.hpp"

#include <algorithm>

#include "config/sections/names.hpp"
#include "contract/errors.hpp"

namespace copepod::coupler {

double step_from_relaxation_time(double relaxation_time, double cell_size_m, double viscosity_m2_per_s) {
  return (relaxation_time - 0.5) / 3.0 * cell_size_m * cell_size_m / viscosity_m2_per_s;
}

double relaxation_time_from_step(double step_s, double cell_size_m, double viscosity_m2_per_s) {
  return 0.5 + 3.0 * viscosity_m2_per_s * step_s / (cell_size_m * cell_size_m);
}

namespace {

FluidKind fluid_kind(FluidSolverChoice choice) {
  switch (choice) {
    case FluidSolverChoice::stokes:
      return FluidKind::stokes;
    case FluidSolverChoice::vacuum:
      return FluidKind::vacuum;
    case FluidSolverChoice::external:  // told everything that the case says about a lattice
    case FluidSolverChoice::lattice_boltzmann:
      break;
  }
  return FluidKind::lattice_boltzmann;
}

void require_lattice_features(const FluidCase& fluid, std::set<std::string>& required) {
  required.insert(std::string("collision:") + name_of(collision_names, fluid.collision));
  required.insert(std::string("precision:") + name_of(precision_names, fluid.precision));
  for (const Boundary& boundary : fluid.boundaries) {
    required.insert(std::string("boundary:") + name_of(boundary_names, boundary.kind));
  }
  for (const bool plane : fluid.symmetry_planes) {
    if (plane) required.insert("symmetry_planes");
  }
}

}  // namespace

FluidSetup make_fluid_setup(const Case& the_case, const Assembly& assembly,
                            const std::string& field_directory) {
  const FluidCase& fluid = the_case.fluid;
  FluidSetup setup;
  setup.kind = fluid_kind(fluid.solver);
  setup.step_s = the_case.step_s;
  setup.cell_size_m = fluid.cell_size_m;
  setup.density_kg_per_m3 = fluid.density_kg_per_m3;
  setup.kinematic_viscosity_m2_per_s = fluid.kinematic_viscosity_m2_per_s;
  setup.domain_cells = fluid.domain_cells;
  setup.boundaries = fluid.boundaries;
  setup.no_slip_plane = fluid.no_slip_plane;
  setup.symmetry_planes = fluid.symmetry_planes;
  setup.body_force_N_per_m3 = fluid.body_force_N_per_m3;
  setup.collision = fluid.collision;
  setup.moving_boundary = fluid.moving_boundary;
  setup.refill = fluid.refill;
  setup.precision = fluid.precision;
  for (const BodySpecification& body : assembly.bodies) setup.bodies.push_back(body.shape);
  setup.fields.directory = field_directory;
  setup.fields.every_steps = the_case.output.fields_every_steps;
  setup.fields.mean_start = the_case.output.mean_over_steps[0];
  setup.fields.mean_stop = the_case.output.mean_over_steps[1];
  setup.fields.mean_every_steps = the_case.output.mean_every_steps;
  return setup;
}

BodySetup make_body_setup(const Case& the_case, const Assembly& assembly) {
  BodySetup setup;
  setup.step_s = the_case.step_s;
  setup.integrator = the_case.body.integrator;
  setup.gravity_m_per_s2 = the_case.gravity_m_per_s2;
  setup.fluid_density_kg_per_m3 =
      the_case.fluid.solver == FluidSolverChoice::vacuum ? 0.0 : the_case.fluid.density_kg_per_m3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (the_case.fluid.boundaries[2 * axis].kind == BoundaryKind::periodic) {
      setup.periodic_length_m[axis] =
          static_cast<double>(the_case.fluid.domain_cells[axis]) * the_case.fluid.cell_size_m;
    }
  }
  setup.bodies = assembly.bodies;
  setup.springs = assembly.springs;
  return setup;
}

std::set<std::string> required_of_fluid(const Case& the_case, const Assembly& assembly) {
  std::set<std::string> required;
  const FluidSolverChoice solver = the_case.fluid.solver;
  if (solver == FluidSolverChoice::external) return required;  // whoever brings a solver knows what it is for
  required.insert(std::string("solver:") + name_of(solver_names, solver));
  if (solver == FluidSolverChoice::vacuum) return required;
  for (const BodySpecification& body : assembly.bodies) {
    required.insert(std::string("shape:") + name_of(shape_names, body.shape.kind));
  }
  if (solver == FluidSolverChoice::stokes && the_case.fluid.no_slip_plane >= 0)
    required.insert("no_slip_plane");
  if (solver == FluidSolverChoice::lattice_boltzmann) require_lattice_features(the_case.fluid, required);
  if (wants_fields(the_case.output) && !computes_no_cells(solver)) required.insert("fields");
  if (the_case.output.checkpoint_every_steps > 0) required.insert("checkpoint");
  return required;
}

std::set<std::string> required_of_body(const Case& the_case, const Assembly& assembly) {
  std::set<std::string> required;
  for (const BodySpecification& body : assembly.bodies) {
    required.insert(std::string("shape:") + name_of(shape_names, body.shape.kind));
    required.insert(std::string("motion:") + name_of(motion_names, body.motion));
  }
  // Everybody else integrates in his own way.
  if (the_case.body.solver == BodySolverChoice::own && the_case.services.body_command.empty()) {
    required.insert(std::string("integrator:") + name_of(integrator_names, the_case.body.integrator));
  }
  const bool periodic =
      std::any_of(the_case.fluid.boundaries.begin(), the_case.fluid.boundaries.end(),
                  [](const Boundary& boundary) { return boundary.kind == BoundaryKind::periodic; });
  if (periodic && the_case.services.body_command.empty()) required.insert("periodic_contacts");
  if (the_case.output.checkpoint_every_steps > 0) required.insert("checkpoint");
  return required;
}

void require_features(const Capabilities& capabilities, const std::set<std::string>& required) {
  std::string missing;
  for (const std::string& feature : required) {
    if (!capabilities.features.contains(feature)) missing += (missing.empty() ? "" : ", ") + feature;
  }
  if (missing.empty() || capabilities.features.contains("solver:external")) return;
  throw Refused("the case needs what " + capabilities.name + " " + capabilities.version + " cannot do (" +
                missing + "). Change the case, or use another component.");
}

std::int64_t computed_cells(const FluidCase& fluid) {
  if (fluid.solver != FluidSolverChoice::lattice_boltzmann) return 0;
  std::int64_t cells = 1;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    cells *= fluid.symmetry_planes[axis] ? fluid.domain_cells[axis] / 2 : fluid.domain_cells[axis];
  }
  return cells;
}

std::int64_t population_bytes(const FluidCase& fluid) {
  const std::int64_t bytes_per_number = fluid.precision == Precision::single_precision ? 4 : 8;
  return computed_cells(fluid) * 19 * bytes_per_number;
}

}  // namespace copepod::coupler
