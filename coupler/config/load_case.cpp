#include "config/load_case.hpp"

#include <algorithm>
#include <cctype>
#include <span>
#include <utility>

#include <nlohmann/json.hpp>

#include "config/checks/checks.hpp"
#include "config/checks/contact_setup.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "config/yaml/yaml_text.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "contract/features.hpp"
#include "geometry/near_pairs.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// Start and stop along x, y and z; a single number is one layer of cells. Empty if no axis is restricted.
std::vector<std::int64_t> read_region(Reader region) {
  std::vector<std::int64_t> result(6);
  bool restricted = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const char* name = axis_names[axis];
    const Value* value = region.raw(name);
    if (value == nullptr) continue;
    restricted = true;
    if (value->kind == Value::Kind::scalar) {
      result[2 * axis] = region.integer(name, Range::not_negative);
      result[2 * axis + 1] = result[2 * axis] + 1;
    } else {
      const auto range = region.integers(name, 2, Range::not_negative);
      std::ranges::copy(range, result.begin() + static_cast<std::ptrdiff_t>(2 * axis));
      if (range[0] >= range[1]) {
        region.reject(name, "is [" + std::to_string(range[0]) + ", " + std::to_string(range[1]) +
                                "] (no cell lies in it). Write [start, stop] with start < stop, or one number.");
      }
    }
  }
  return restricted ? result : std::vector<std::int64_t>{};
}

ordered_json resolved_region(const std::vector<std::int64_t>& region) {
  ordered_json result = ordered_json::object();
  for (std::size_t axis = 0; axis < 3 && !region.empty(); ++axis)
    if (region[2 * axis + 1] > 0) result[axis_names[axis]] = {region[2 * axis], region[2 * axis + 1]};
  return result;
}

std::vector<FieldQuantity> read_quantities(Reader& fields) {
  std::vector<FieldQuantity> result;
  const std::string known = "density, velocity, pressure, vorticity";
  for (const std::string& word : fields.words("quantities")) {
    const auto found = std::ranges::find(quantity_names, word, &Choice<FieldQuantity>::name);
    if (found == quantity_names.end()) {
      fields.reject("quantities", "names '" + word + "' (known: " + known + "). Use these.");
    } else if (std::ranges::find(result, found->value) != result.end()) {
      fields.reject("quantities", "names " + word + " twice (once is enough). Remove one.");
    } else {
      result.push_back(found->value);
    }
  }
  if (result.empty()) result = {FieldQuantity::density, FieldQuantity::velocity};
  return result;
}

ordered_json resolved_quantities(const std::vector<FieldQuantity>& quantities) {
  ordered_json result = ordered_json::array();
  for (const FieldQuantity quantity : quantities) result.push_back(name_of(quantity_names, quantity));
  return result;
}

/// A hundred frames, at steps that are in the trajectory too.
std::int64_t usual_steps_between_frames(std::int64_t steps, std::int64_t trajectory_every_steps) {
  constexpr std::int64_t frames = 100;
  const std::int64_t unit = std::max<std::int64_t>(trajectory_every_steps, 1);
  return std::max<std::int64_t>((steps + frames * unit - 1) / (frames * unit), 1) * unit;
}

OutputCase read_output(Reader output, std::int64_t steps) {
  OutputCase result;
  {
    Reader trajectory = output.section("trajectory");
    result.trajectory_every_steps = trajectory.integer("every_steps", Range::not_negative, 100);
    result.trajectory_from_step = trajectory.integer("from_step", Range::not_negative, 0);
    result.trajectory_format =
        trajectory.choice("format", trajectory_format_names, std::optional(TrajectoryFormat::by_bodies));
  }
  {
    Reader bodies = output.section("bodies");
    result.bodies_every_steps = bodies.integer("every_steps", Range::not_negative,
                                               usual_steps_between_frames(steps, result.trajectory_every_steps));
  }
  {
    Reader fields = output.section("fields");
    result.fields.every_steps = fields.integer("every_steps", Range::not_negative, 0);
    const auto mean = fields.integers("mean_over_steps", 2, Range::not_negative, std::vector<std::int64_t>{0, 0});
    result.fields.mean_start = mean[0];
    result.fields.mean_stop = mean[1];
    result.fields.mean_every_steps = fields.integer("mean_every_steps", Range::positive, 10);
    result.fields.quantities = read_quantities(fields);
    result.fields.region_cells = read_region(fields.section("region_cells"));
    result.fields.compression = fields.choice("compression", compression_names, std::optional(0));
  }
  result.wire = output.choice("wire", switch_names, std::optional(false));
  result.trace = output.choice("trace", switch_names, std::optional(false));
  Reader checkpoint = output.section("checkpoint");
  result.checkpoint_every_steps = checkpoint.integer("every_steps", Range::not_negative, 0);
  result.checkpoint_every_wall_s = checkpoint.number("every_wall_s", Range::not_negative, 600.0);
  return result;
}

ordered_json resolved_output(const OutputCase& output) {
  return {{"trajectory",
           {{"every_steps", output.trajectory_every_steps},
            {"from_step", output.trajectory_from_step},
            {"format", name_of(trajectory_format_names, output.trajectory_format)}}},
          {"bodies", {{"every_steps", output.bodies_every_steps}}},
          {"fields",
           {{"every_steps", output.fields.every_steps},
            {"mean_over_steps", {output.fields.mean_start, output.fields.mean_stop}},
            {"mean_every_steps", output.fields.mean_every_steps},
            {"quantities", resolved_quantities(output.fields.quantities)},
            {"region_cells", resolved_region(output.fields.region_cells)},
            {"compression", name_of(compression_names, output.fields.compression)}}},
          {"checkpoint",
           {{"every_steps", output.checkpoint_every_steps}, {"every_wall_s", output.checkpoint_every_wall_s}}},
          {"wire", name_of(switch_names, output.wire)},
          {"trace", name_of(switch_names, output.trace)}};
}

/// `none`, `auto` (absent), or a number.
std::optional<double> read_number_or_auto(Reader& section, const char* key, const char* default_word,
                                          const char* number_of) {
  const Value* value = section.raw(key);
  const std::string word = value == nullptr ? default_word : value->text;
  if (word == "auto") return {};
  if (word == "none") return 0.0;
  if (value->kind == Value::Kind::scalar && std::isalpha(static_cast<unsigned char>(word.front())) != 0) {
    section.reject(key, "is '" + word + "' (known: auto, none). Write one of these, or a number of " + number_of + ".");
    return {};
  }
  return section.number(key, Range::not_negative);
}

ordered_json resolved_number_or_auto(const std::optional<double>& number) {
  if (!number) return "auto";
  return *number > 0.0 ? ordered_json(*number) : ordered_json("none");
}

/// Also sets the fluid's part of it.
LubricationCase read_lubrication(Reader lubrication, FluidCase& fluid) {
  constexpr double calibrated_cells = 1.5;  // docs/decisions/lubrication.md
  LubricationCase result;
  result.cut_off_cells = read_number_or_auto(lubrication, "cut_off_cells", "auto", "cells");
  result.roughness_m = lubrication.number("roughness_m", Range::positive, result.roughness_m);
  if (fluid.kind == FluidKind::lattice_boltzmann)
    fluid.film_thickness_m = result.cut_off_cells.value_or(calibrated_cells) * fluid.cell_size_m;
  return result;
}

BodyCase read_body_solver(Reader body) {
  BodyCase result;
  result.solver = read_solver(body, body_solver_names, std::optional(BodySolverChoice::own), result.command);
  result.integrator = body.choice("integrator", integrator_names, std::optional(Integrator::runge_kutta_4));
  if (body.has("model")) read_model(body, result);
  return result;
}

/// Processes of fluid and bodies: a command in `services` (where --fluid and --body put theirs) takes
/// precedence over one in `solver`, and a solver without cells runs on one rank.
void settle_services(const FluidCase& fluid, const BodyCase& body, ServicesCase& services) {
  if (services.fluid_command.empty()) services.fluid_command = fluid.command;
  if (services.body_command.empty()) services.body_command = body.command;
  if (computes_no_cells(fluid.solver) && services.fluid_command.empty()) services.fluid_ranks = 1;
}

/// Text for few bodies, HDF5 for many [docs/decisions/trajectories.md].
void settle_trajectory(std::size_t bodies, OutputCase& output) {
  constexpr std::size_t few = 100;
  if (output.trajectory_format == TrajectoryFormat::by_bodies)
    output.trajectory_format = bodies > few ? TrajectoryFormat::hdf5 : TrajectoryFormat::csv;
}

double derived_step_s(const Case& the_case) {
  if (the_case.given_step_s) return *the_case.given_step_s;
  const FluidCase& fluid = the_case.fluid;
  if (!fluid.relaxation_time || fluid.cell_size_m <= 0.0 || fluid.kinematic_viscosity_m2_per_s <= 0.0) return 0.0;
  return step_from_relaxation_time(*fluid.relaxation_time, fluid.cell_size_m, fluid.kinematic_viscosity_m2_per_s);
}

template <typename Item>
ordered_json list(const std::vector<Item>& items, ordered_json (*resolve)(const Item&)) {
  ordered_json result = ordered_json::array();
  for (const Item& item : items) result.push_back(resolve(item));
  return result;
}

}  // namespace

Case read_case(Reader top) {
  Case result;
  result.name = top.name("case");
  result.parameter_set = top.text("parameter_set", "");
  { top.section("parameter_sets").accept_all(); }
  static_cast<void>(top.has("forces"));  // an empty list is in the resolved cases of release 1.0
  result.fluid = read_fluid(top.section("fluid"));
  if (top.has("step_s")) result.given_step_s = top.number("step_s", Range::positive);
  result.step_s = derived_step_s(result);
  result.body = read_body_solver(top.section("body"));
  for (std::size_t i = 0; i < top.size("swimmers"); ++i)
    result.swimmers.push_back(read_swimmer(top.item("swimmers", i), result.step_s));
  for (std::size_t i = 0; i < top.size("bodies"); ++i)
    result.bodies.push_back(read_body(top.item("bodies", i), result.step_s));
  if (top.has("swarm")) read_swarm(top.section("swarm"), result);
  for (std::size_t i = 0; i < top.size("groups"); ++i) result.groups.push_back(read_group(top.item("groups", i)));
  for (std::size_t i = 0; i < top.size("springs"); ++i) result.springs.push_back(read_spring(top.item("springs", i)));
  for (std::size_t i = 0; i < top.size("bends"); ++i) result.bends.push_back(read_named_bend(top.item("bends", i)));
  for (std::size_t i = 0; i < top.size("joints"); ++i)
    result.joints.push_back(read_joint(top.item("joints", i), result.step_s));
  for (std::size_t i = 0; i < top.size("actuators"); ++i)
    result.actuators.push_back(read_actuator(top.item("actuators", i), result.step_s));
  result.body.gravity_m_per_s2 = top.numbers("gravity_m_per_s2", 3, Eigen::VectorXd::Zero(3));
  {
    Reader coupling = top.section("coupling");
    coupling.choice("scheme", scheme_names, std::optional(SchemeKind::serial_explicit));
    result.load_averaging = coupling.choice("load_averaging", averaging_names, std::optional(LoadAveraging::two_step));
    result.virtual_mass = read_number_or_auto(coupling, "virtual_mass", "auto", "displaced masses");
  }
  result.lubrication = read_lubrication(top.section("lubrication"), result.fluid);
  if (top.has("contact")) result.contact = read_contact(top.section("contact"));
  {
    Reader run = top.section("run");
    result.steps = run.integer("steps", Range::positive);
  }
  result.output = read_output(top.section("output"), result.steps);
  result.services = read_services(top.section("services"));
  settle_services(result.fluid, result.body, result.services);
  if (!result.body.model_file.empty()) read_bodies_of_model(result, top.problems());
  static_cast<void>(top.has("sweep"));  // read before, see `read_members`
  return result;
}

ordered_json resolved(const Case& the_case) {
  ordered_json top{{"case", the_case.name}};
  if (!the_case.parameter_set.empty()) top["parameter_set"] = the_case.parameter_set;
  top["fluid"] = resolved_fluid(the_case.fluid);
  if (the_case.given_step_s) top["step_s"] = *the_case.given_step_s;
  top["body"] = {{"solver", name_of(body_solver_names, the_case.body.solver)},
                 {"integrator", name_of(integrator_names, the_case.body.integrator)}};
  if (!the_case.body.model.text.empty()) top["body"]["model"] = resolved_model(the_case.body.model);
  top["swimmers"] = list(the_case.swimmers, resolved_swimmer);
  top["bodies"] = list(the_case.bodies, resolved_body);
  top["groups"] = list(the_case.groups, resolved_group);
  top["springs"] = list(the_case.springs, resolved_spring);
  top["bends"] = list(the_case.bends, resolved_named_bend);
  if (!the_case.joints.empty()) top["joints"] = list(the_case.joints, resolved_joint);
  top["actuators"] = list(the_case.actuators, resolved_actuator);
  top["gravity_m_per_s2"] = the_case.body.gravity_m_per_s2;
  top["coupling"] = {{"scheme", name_of(scheme_names, SchemeKind::serial_explicit)},
                     {"load_averaging", name_of(averaging_names, the_case.load_averaging)},
                     {"virtual_mass", resolved_number_or_auto(the_case.virtual_mass)}};
  top["lubrication"] = {{"cut_off_cells", resolved_number_or_auto(the_case.lubrication.cut_off_cells)},
                        {"roughness_m", the_case.lubrication.roughness_m}};
  if (the_case.contact) top["contact"] = resolved_contact(*the_case.contact);
  top["run"] = {{"steps", the_case.steps}};
  top["output"] = resolved_output(the_case.output);
  top["services"] = resolved_services(the_case.services);
  return top;
}

ordered_json physics_of(Case the_case) {
  for (Swimmer& swimmer : the_case.swimmers) swimmer.published.clear();
  ordered_json physics = resolved(the_case);
  for (const char* section : {"run", "output", "services"}) physics.erase(section);
  return physics;
}

std::string case_key(const Case& the_case) { return std::to_string(digest_of(to_yaml(physics_of(the_case)))); }

namespace {

/// The form of older versions.
void refuse_forces(const Document& document) {
  const Value* forces = document.root().find("forces");
  const bool empty = forces != nullptr && forces->kind == Value::Kind::sequence && forces->items.empty();
  if (forces == nullptr || empty) return;
  throw CaseInvalid(document.locate("forces"),
                    "forces has become actuators (they can follow a body or an arm). Write actuators: [{kind: "
                    "world_force, body: a, direction: [0, 0, 1], signal: {kind: constant, amplitude_N: 1.0e-9}}], or "
                    "signal: {kind: sinusoid, amplitude_N: …, period_steps: …, lag_steps: …}.");
}

void refuse_campaign(const Document& document) {
  if (document.root().find("campaign") == nullptr) return;
  throw CaseInvalid(document.locate("campaign"),
                    "the file is a campaign (a list of cases). Run it with `copepod campaign`, or name one of its "
                    "cases.");
}

LoadedCase read_one(const Document& document, AskedKeys* asked) {
  refuse_forces(document);
  Problems problems(document);
  LoadedCase loaded;
  loaded.content = read_case(Reader(&document.root(), "", problems, asked));
  loaded.assembly = assemble(loaded.content);
  settle_trajectory(loaded.assembly.bodies.size(), loaded.content.output);
  check_case(loaded.content, loaded.assembly, problems);
  problems.throw_if_any();
  loaded.warnings = problems.warnings();
  return loaded;
}

/// Lines of several members of a sweep, each with the members that have it.
class LinesOfMembers {
 public:
  void add(const std::string& line, const std::string& member) {
    const auto found = std::ranges::find(lines_, line, &Line::text);
    if (found != lines_.end())
      ++found->members;
    else
      lines_.push_back({line, member, 1});
  }

  [[nodiscard]] bool empty() const { return lines_.empty(); }

  /// With the first of the members, unless all of them have the line.
  [[nodiscard]] std::vector<std::string> texts(std::size_t members) const {
    constexpr std::size_t most = 20;
    std::vector<std::string> result;
    for (const Line& line : std::span(lines_).first(std::min(most, lines_.size()))) {
      const std::string others =
          line.members == 1 ? ""
                            : " and " + std::to_string(line.members - 1) + (line.members == 2 ? " other" : " others");
      result.push_back(line.members == members ? line.text
                                               : line.text + " [in member " + line.first_member + others + "]");
    }
    if (lines_.size() > most) result.push_back("… and " + std::to_string(lines_.size() - most) + " more like these.");
    return result;
  }

 private:
  struct Line {
    std::string text;
    std::string first_member;
    std::size_t members;
  };
  std::vector<Line> lines_;
};

/// Checks every member of a sweep, so that none fails after hours.
LoadedCase read_members(const Document& document, const Sweep& sweep, AskedKeys* asked) {
  LinesOfMembers errors, warnings;
  std::optional<LoadedCase> first;
  const std::size_t members = member_count(sweep);
  for (std::size_t member = 0; member < members; ++member) {
    try {
      LoadedCase loaded = read_one(document.with(assignments_of(sweep, member)), asked);
      for (const std::string& line : loaded.warnings) warnings.add(line, member_text(sweep, member));
      if (!first) first = std::move(loaded);
    } catch (const CaseInvalid& invalid) {
      for (const std::string& line : invalid.lines()) errors.add(line, member_text(sweep, member));
    }
  }
  if (!errors.empty()) throw CaseInvalid(errors.texts(members));
  first->warnings = warnings.texts(members);
  first->sweep = sweep;
  return std::move(*first);
}

LoadedCase read_document(const Document& document, AskedKeys* asked) {
  refuse_campaign(document);
  const std::optional<Sweep> sweep = read_sweep(document, asked);
  return sweep ? read_members(document, *sweep, asked) : read_one(document, asked);
}

std::string joined(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

LoadedCase load_case(const std::string& file, const std::vector<std::string>& overrides) {
  return read_document(Document::load(file, overrides), nullptr);
}

LoadedCase load_case_text(const std::string& text, const std::string& source, const std::vector<std::string>& overrides,
                          AskedKeys* asked) {
  return read_document(Document::parse(text, source, overrides), asked);
}

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
    throw Refused("the case needs what " + who + " cannot do (" + joined(comparison.missing) +
                  "). Change the case, or use another component." + (notices.empty() ? "" : " ") + joined(notices));
  }
  if (!comparison.neglected.empty())
    notices.push_back(who + " neglects " + joined(comparison.neglected) + " (the case uses it).");
  return notices;
}

}  // namespace copepod::coupler
