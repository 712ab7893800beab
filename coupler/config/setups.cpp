#include "config/setups.hpp"

#include "config/checks/contact_setup.hpp"
#include "config/yaml/hints.hpp"
#include "contract/errors.hpp"
#include "contract/features.hpp"
#include "geometry/near_pairs.hpp"

namespace copepod::coupler {
FluidSetup make_fluid_setup(const Case& the_case, const Assembly& assembly, const std::string& field_directory) {
  FluidSetup setup = static_cast<const FluidSetup&>(the_case.fluid);
  setup.step_s = the_case.step_s;
  for (const BodySpecification& body : assembly.bodies) setup.bodies.push_back(body.shape);
  setup.jointed = jointed_pairs(assembly.joints);
  constexpr double of_a_cell = 0.25;  // contacts are soft
  if (the_case.contact) setup.wall_overlap_m = of_a_cell * setup.cell_size_m;
  setup.fields = the_case.output.fields;
  setup.fields.directory = field_directory;
  return setup;
}

BodySetup make_body_setup(const Case& the_case, const Assembly& assembly) {
  const FluidCase& fluid = the_case.fluid;
  BodySetup setup = static_cast<const BodySetup&>(the_case.body);
  setup.threads = the_case.services.body_threads;
  setup.step_s = the_case.step_s;
  setup.fluid_density_kg_per_m3 = fluid.kind == FluidKind::vacuum ? 0.0 : fluid.density_kg_per_m3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (fluid.boundaries[2 * axis].kind != BoundaryKind::periodic) continue;
    setup.periodic_length_m[axis] = static_cast<double>(fluid.domain_cells[axis]) * fluid.cell_size_m;
  }
  setup.bodies = assembly.bodies;
  setup.springs = assembly.springs;
  setup.bends = assembly.bends;
  setup.joints = assembly.joints;
  for (const DrivenActuator& driven : assembly.drive) setup.actuators.push_back(driven.actuator);
  setup.contact = contact_specification(the_case, assembly);
  setup.walls = contact_walls(the_case);
  take_out(assembly.prescribed, setup);
  return setup;
}

std::set<std::string> required_of_fluid(const Case& the_case, const Assembly& assembly) {
  std::set<std::string> required = required_features(make_fluid_setup(the_case, assembly, ""));
  if (the_case.fluid.solver == FluidSolverChoice::external) required = without_methods(std::move(required));
  if (!the_case.lubrication.cut_off_cells) required.erase("thin_films");  // auto: with fluids that have them
  if (the_case.output.checkpoint_every_steps > 0) required.insert("checkpoint");
  return required;
}

std::set<std::string> required_of_body(const Case& the_case, const BodySetup& setup) {
  std::set<std::string> required = required_features(setup);
  // Other solvers integrate in their own way.
  const bool ours = the_case.body.solver == BodySolverChoice::own && the_case.services.body_command.empty();
  if (!ours) required = without_methods(std::move(required));
  if (the_case.output.checkpoint_every_steps > 0) required.insert("checkpoint");
  return required;
}

std::vector<std::string> require_features(const Capabilities& capabilities, const std::set<std::string>& required) {
  const FeatureComparison comparison = compare_features(required, capabilities.features);
  const std::string who = capabilities.name + " " + capabilities.version;
  std::vector<std::string> notices;
  for (const auto& [name, nearest] : comparison.unknown) {
    const std::string meant = nearest.empty() ? "" : " Did you mean '" + nearest + "'?";
    notices.push_back(who + " announces '" + name + "' (not a known feature)." + meant);
  }
  if (!comparison.missing.empty()) {
    throw Refused("the case needs what " + who + " cannot do (" + listed(comparison.missing) +
                  "). Change the case, or use another component." + (notices.empty() ? "" : " ") + listed(notices));
  }
  if (!comparison.neglected.empty())
    notices.push_back(who + " neglects " + listed(comparison.neglected) + " (the case uses it).");
  return notices;
}

}  // namespace copepod::coupler
