#include <algorithm>
#include <utility>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "contract/digest.hpp"

// The whole case, and its short sections.

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

void declare(Keys& keys, BodyCase& body) {
  declare_solver(keys, "solver", body.solver, body_solver_names, body.command, body.parameters,
                 "own: the body service of Copepod; bullet: the Bullet library, which keeps bodies that touch apart; "
                 "mujoco: the MuJoCo library, with joints and contacts; {command: …}: your own component.");
  keys.choice("integrator", body.integrator, integrator_names,
              "runge_kutta_4: classical, driving forces sampled inside the step; semi_implicit_euler: the paper's. "
              "Applies to solver: own; other solvers have their own integrators.");
  declare_model(keys, body);
}

void declare_coupling(Keys& keys, Case& the_case) {
  auto scheme = SchemeKind::serial_explicit;
  keys.choice("scheme", scheme, scheme_names, "serial_explicit: one after the other, once per step.");
  keys.choice("load_averaging", the_case.load_averaging, averaging_names,
              "two_step: bodies receive the mean of the loads of this step and the previous one, which keeps light "
              "bodies stable; none: the loads of this step.");
  keys.number_or("virtual_mass", the_case.virtual_mass, Range::not_negative, "auto", "none", "displaced masses",
                 "Mass by which light bodies are enlarged while the coupling returns its load one step later, so that "
                 "they move like the true ones and stay stable: a number of displaced masses for all bodies, none, or "
                 "auto: as much as each body needs, 0 for heavy ones. In Stokes flow auto makes steps possible in "
                 "which a body loses all of its momentum, and returns nothing (docs/theory.md, C19).");
}

void declare(Keys& keys, LubricationCase& lubrication) {
  keys.number_or("cut_off_cells", lubrication.cut_off_cells, Range::not_negative, "auto", "none", "cells",
                 "Thickness of the films [cells]: where surfaces are closer, give or take half a cell, loads come from "
                 "theory. auto: 1.5 with fluids that announce thin_films, none with others; none: no films, the cells' "
                 "loads as they are.");
  keys.number("roughness_m", lubrication.roughness_m, Range::positive, "Films do not get thinner than this [m].");
}

void declare(Keys& keys, ContactCase& contact) {
  constexpr double least_restitution = 0.05;  // less would need more damping than substeps resolve
  keys.number("restitution", contact.restitution, Range::positive,
              "Normal velocity after an impact over that before, without a fluid.");
  keys.describe_also("restitution", {{"minimum", least_restitution}, {"maximum", 1}});
  keys.reject_if(contact.restitution < least_restitution || contact.restitution > 1.0, "restitution",
                 "is " + rounded_text(contact.restitution) +
                     " (the velocity after an impact over that before). Use a number between 0.05 and 1.");
  keys.number("friction", contact.friction, Range::not_negative, "Coulomb coefficient between bodies.");
  keys.number("wall_friction", contact.wall_friction, Range::not_negative,
              "Coulomb coefficient between bodies and walls where the fluid sticks. Default: that of friction.");
  keys.number_or(
      "stiffness_N_per_m", contact.stiffness_N_per_m, Range::positive, "auto", "", "N/m",
      "Of the normal spring [N/m]. auto: overlaps stay below about 1 % of the smallest radius, judged by weights, "
      "drives, the speeds at the start and those of settling; at least the stiffest that needs no substeps.");
}

/// Processes of fluid and bodies: a command in `services` (where --fluid and --body put theirs) takes
/// precedence over one in `solver`, and a solver without cells runs on one rank.
void settle_services(FluidCase& fluid, BodyCase& body, ServicesCase& services) {
  if (services.fluid_command.empty()) services.fluid_command = fluid.command;
  if (services.body_command.empty()) services.body_command = body.command;
  if (fluid.parameters.empty()) fluid.parameters = services.fluid_parameters;
  if (body.parameters.empty()) body.parameters = services.body_parameters;
  services.fluid_parameters = fluid.parameters;
  services.body_parameters = body.parameters;
  if (computes_no_cells(fluid.solver) && services.fluid_command.empty()) services.fluid_ranks = 1;
}

/// Keys that are read elsewhere, or by older versions only.
void declare_set_aside(Keys& keys) {
  static_cast<void>(keys.mapping("parameter_sets"));
  for (const char* key : {"forces", "sweep"}) static_cast<void>(keys.raw(key));
  keys.describe("parameter_sets", {{"type", "object"}, {"additionalProperties", {{"type", "object"}}}},
                "Alternative values, by name: each set is a mapping from key path "
                "(swimmers.0.spring.stiffness_N_per_m) to value.");
  keys.describe("forces", {{"type", "array"}, {"maxItems", 0}},
                "Replaced by actuators; the empty list of cases that release 1.0 resolved is ignored.");
  if (keys.describes()) describe_sweep(keys);
}

/// Everything solid, and what joins and drives it.
void declare_bodies(Keys& keys, Case& the_case) {
  const double step_s = the_case.step_s;
  const auto item = [](Keys& below, auto& each) { declare(below, each); };
  const auto item_in_time = [&](Keys& below, auto& each) { declare(below, each, step_s); };
  keys.list("swimmers", the_case.swimmers,
            "Swimmers: beads, the arms between them and what drives the arms; also what the analysis works "
            "on. In general any number of beads and arms; without arms, the three-bead shorthand (NAME.B2 "
            "trailing, NAME.B1 middle, NAME.B3 leading in a row, one mass, one kind of spring, one stroke).",
            [&](Keys& below, Swimmer& swimmer) { declare(below, swimmer, step_s, true); });
  keys.list("bodies", the_case.bodies, "Bodies that are not part of a swimmer.", item_in_time);
  if (keys.written_if(!the_case.fluid.obstacles.empty()))
    keys.list(
        "obstacles", the_case.fluid.obstacles,
        "With solver: lattice_boltzmann, solid parts of the domain that never move. They may reach beyond its faces "
        "and into each other; a body that meets one ends the run.",
        [](Keys& obstacle, ObstacleSpecification& item) {
          obstacle.name(required("name"), item.name, "Name in messages.");
          declare(obstacle, item.shape);
          obstacle.numbers(required("position_m"), item.position_m, "Place of the shape's own frame [m].");
          declare_orientation(obstacle, item.orientation_wxyz, "Orientation: unit quaternion.");
          obstacle.flag(
              "loads", item.loads,
              "Whether the fluid's force and torque on it are written: obstacles.csv, in the form of the trajectory.");
        });
  declare_swarm(keys, the_case);
  keys.list("groups", the_case.groups,
            "Bodies whose motion is measured together, cycle by cycle, like that of a swimmer.", item);
  keys.list("springs", the_case.springs, "Springs with dampers that are not part of a swimmer.", item);
  keys.list("bends", the_case.bends, "Springs of angles between three bodies.", item);
  if (keys.written_if(!the_case.joints.empty()))
    keys.list("joints", the_case.joints,
              "Ideal joints between two bodies, or between a body and the world; where its bodies start "
              "determines what a joint keeps. Jointed bodies may overlap.",
              item_in_time);
  keys.list(
      "actuators", the_case.actuators,
      "What drives bodies: forces along the line between two, forces and torques fixed to a body or in the world.",
      item_in_time);
  if (keys.written_if(!the_case.controllers.empty()))
    keys.list("controllers", the_case.controllers,
              "Components that observe bodies now and then, and decide what actuators do (docs/controllers.md).", item);
  keys.numbers("gravity_m_per_s2", the_case.body.gravity_m_per_s2, "Gravity; weight less buoyancy acts on the bodies.");
}

/// Of what drives the bodies, and of the groups; 0: none.
std::int64_t longest_period_steps(const Case& the_case) {
  std::int64_t longest = 0;
  for (const NamedGroup& group : the_case.groups) longest = std::max(longest, group.period_steps);
  for (const DrivenActuator& each : assemble(the_case).drive) longest = std::max(longest, each.signal.period_steps);
  return longest;
}

/// The bound by cycles is the default of the bound by steps; if both are given, the smaller one counts.
void declare_run(Keys& run, Case& the_case) {
  constexpr std::int64_t most_steps = 1'000'000'000'000;
  run.section<Periodicity>("until_periodic", the_case.until_periodic,
                           "The run ends after the first cycle in which every swimmer moves as in the cycle before.",
                           [](Keys& below, Periodicity& periodicity) {
                             below.number("tolerance", periodicity.tolerance, Range::positive,
                                          "Largest change of motion, relative to it.");
                             below.integer("cycles", periodicity.cycles, Range::not_negative,
                                           "The most cycles, of the longest period in the case, if the motion does not "
                                           "become periodic; 0: as many as fit into run.steps.");
                           });
  std::int64_t bound = 0;
  if (run.reads() && the_case.until_periodic && the_case.until_periodic->cycles > 0)
    if (const std::int64_t period = longest_period_steps(the_case); period > 0)
      bound = std::min(the_case.until_periodic->cycles, most_steps / period) * period;
  the_case.steps = bound > 0 ? bound : the_case.steps;
  run.integer(run.needed("steps", bound == 0), the_case.steps, Range::positive,
              "Number of coupling steps, or the most of them; may be left out with until_periodic.cycles.");
  if (bound > 0) the_case.steps = std::min(the_case.steps, bound);
}

void declare(Keys& keys, Case& the_case) {
  keys.name(required("case"), the_case.name, "Name of the case, for people and for the default run directory.");
  if (keys.written_if(!the_case.parameter_set.empty()))
    keys.text("parameter_set", the_case.parameter_set,
              "The entry of parameter_sets to apply. In a resolved case: the label of the applied entry.");
  keys.number("step_s", the_case.given_step_s, Range::positive,
              "Length of a coupling step [s]. Give this or fluid.relaxation_time.");
  keys.section(required("fluid"), "The fluid and its solver.",
               [&](Keys& fluid) { declare(fluid, the_case.fluid, the_case.given_step_s); });
  if (keys.reads()) the_case.step_s = step_of(the_case.fluid, the_case.given_step_s);
  keys.section("body", "The body solver.", [&](Keys& body) { declare(body, the_case.body); });
  declare_bodies(keys, the_case);
  keys.section("coupling", "Coupling of fluid and bodies.",
               [&](Keys& coupling) { declare_coupling(coupling, the_case); });
  keys.section("lubrication",
               "Thin films between surfaces: what their cells cannot resolve is taken from lubrication theory.",
               [&](Keys& lubrication) { declare(lubrication, the_case.lubrication); });
  keys.section<ContactCase>("contact", the_case.contact,
                            "Bodies that meet each other or a wall of the domain rebound. Without this section a run "
                            "in which bodies meet ends with an error.",
                            [](Keys& below, ContactCase& contact) { declare(below, contact); });
  keys.section(required("run"), "Length of the run.", [&](Keys& run) { declare_run(run, the_case); });
  keys.section("output", "What is written to the run directory.",
               [&](Keys& output) { declare(output, the_case.output, the_case.fluid, the_case.steps); });
  keys.section("services", "How the components are started; read by the deploy command.",
               [&](Keys& services) { declare(services, the_case.services); });
  declare_set_aside(keys);
}

void collect_paths(const ordered_json& node, const std::string& path, std::vector<std::string>& paths) {
  for (const ordered_json& form : node.value("anyOf", ordered_json::array())) collect_paths(form, path, paths);
  if (node.contains("items")) collect_paths(node["items"], path + ".[]", paths);
  const ordered_json properties = node.value("properties", ordered_json::object());
  for (const auto& [key, child] : properties.items()) {
    paths.push_back(path.empty() ? key : path + "." + key);
    collect_paths(child, std::string(paths.back()), paths);
  }
}

}  // namespace

const std::vector<std::string>& case_keys() {
  static const std::vector<std::string> keys = [] {
    std::vector<std::string> paths;
    collect_paths(case_schema(), "", paths);
    return paths;
  }();
  return keys;
}

Case read_case(const Document& document, Problems& problems) {
  Case result;
  Keys top(&document.root(), "", problems);
  declare(top, result);
  constexpr double calibrated_cells = 1.5;  // docs/decisions/lubrication.md
  FluidCase& fluid = result.fluid;
  if (fluid.kind == FluidKind::lattice_boltzmann)
    fluid.film_thickness_m = result.lubrication.cut_off_cells.value_or(calibrated_cells) * fluid.cell_size_m;
  settle_services(fluid, result.body, result.services);
  if (!result.body.model_file.empty()) read_bodies_of_model(result, problems);
  return result;
}

ordered_json resolved(Case the_case) {
  return Keys::written([&](Keys& keys) { declare(keys, the_case); });
}

ordered_json case_schema() {
  Case any;
  return schema_of_file(
      "case", "One simulation: a fluid, the bodies in it, and their coupling. SI units; every key names its unit.",
      [&](Keys& keys) { declare(keys, any); });
}

ordered_json physics_of(Case the_case) {
  for (Swimmer& swimmer : the_case.swimmers) swimmer.published.clear();
  for (Coefficients& each : the_case.output.coefficients) each.from_step = 0;
  ordered_json physics = resolved(std::move(the_case));
  const ordered_json coefficients = physics["output"].value("coefficients", ordered_json());
  for (const char* section : {"run", "output", "services"}) physics.erase(section);
  if (!coefficients.is_null()) physics["output"]["coefficients"] = coefficients;
  return physics;
}

std::string case_key(const Case& the_case) { return std::to_string(digest_of(to_yaml(physics_of(the_case)))); }

}  // namespace copepod::coupler
