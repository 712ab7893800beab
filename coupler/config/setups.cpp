#include "config/setups.hpp"

#include <algorithm>

#include "config/sections/names.hpp"
#include "contract/errors.hpp"
#include "contract/features.hpp"

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

std::string joined(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
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
  std::set<std::string> required = required_features(make_fluid_setup(the_case, assembly, ""));
  if (the_case.fluid.solver == FluidSolverChoice::external) required = without_methods(std::move(required));
  if (the_case.output.checkpoint_every_steps > 0) required.insert("checkpoint");
  return required;
}

std::set<std::string> required_of_body(const Case& the_case, const Assembly& assembly) {
  std::set<std::string> required = required_features(make_body_setup(the_case, assembly));
  // Other solvers integrate in their own way.
  const bool ours = the_case.body.solver == BodySolverChoice::own && the_case.services.body_command.empty();
  if (!ours) required = without_methods(std::move(required));
  if (the_case.output.checkpoint_every_steps > 0) required.insert("checkpoint");
  return required;
}

std::vector<std::string> require_features(const Capabilities& capabilities,
                                          const std::set<std::string>& required) {
  const FeatureComparison comparison = compare_features(required, capabilities.features);
  const std::string who = capabilities.name + " " + capabilities.version;
  std::vector<std::string> notices;
  for (const auto& [name, nearest] : comparison.unknown) {
    const std::string meant = nearest.empty() ? "" : " Did you mean '" + nearest + "'?";
    notices.push_back(who + " announces '" + name + "' (not a known feature)." + meant);
  }
  if (!comparison.missing.empty()) {
    throw Refused("the case needs what " + who + " cannot do (" + joined(comparison.missing) +
                  "). Change the case, or use another component." + (notices.empty() ? "" : " ") +
                  joined(notices));
  }
  if (!comparison.neglected.empty())
    notices.push_back(who + " neglects " + joined(comparison.neglected) + " (the case uses it).");
  return notices;
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
