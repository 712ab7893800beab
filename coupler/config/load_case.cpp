#include "config/load_case.hpp"

#include <algorithm>
#include <utility>

#include "config/checks/checks.hpp"
#include "config/sections/sections.hpp"
#include "config/yaml/document.hpp"
#include "config/yaml/yaml_text.hpp"
#include "contract/digest.hpp"
#include "contract/errors.hpp"
#include "contract/features.hpp"

namespace copepod::coupler {
namespace {

OutputCase read_output(Reader output) {
  OutputCase result;
  {
    Reader trajectory = output.section("trajectory");
    result.trajectory_every_steps = trajectory.integer("every_steps", Range::not_negative, 100);
    result.trajectory_from_step = trajectory.integer("from_step", Range::not_negative, 0);
  }
  {
    Reader fields = output.section("fields");
    result.fields.every_steps = fields.integer("every_steps", Range::not_negative, 0);
    const auto mean = fields.integers("mean_over_steps", 2, Range::not_negative, std::vector<std::int64_t>{0, 0});
    result.fields.mean_start = mean[0];
    result.fields.mean_stop = mean[1];
    result.fields.mean_every_steps = fields.integer("mean_every_steps", Range::positive, 10);
  }
  result.wire = output.choice("wire", switch_names, std::optional(false));
  result.trace = output.choice("trace", switch_names, std::optional(false));
  Reader checkpoint = output.section("checkpoint");
  result.checkpoint_every_steps = checkpoint.integer("every_steps", Range::not_negative, 0);
  result.checkpoint_every_wall_s = checkpoint.number("every_wall_s", Range::not_negative, 600.0);
  return result;
}

Value resolved_output(const OutputCase& output) {
  Value trajectory = Value::mapping();
  trajectory.add("every_steps", Value::of_integer(output.trajectory_every_steps));
  trajectory.add("from_step", Value::of_integer(output.trajectory_from_step));
  Value fields = Value::mapping();
  fields.add("every_steps", Value::of_integer(output.fields.every_steps));
  Value mean = Value::sequence();
  mean.add(Value::of_integer(output.fields.mean_start)).add(Value::of_integer(output.fields.mean_stop));
  fields.add("mean_over_steps", std::move(mean));
  fields.add("mean_every_steps", Value::of_integer(output.fields.mean_every_steps));
  Value checkpoint = Value::mapping();
  checkpoint.add("every_steps", Value::of_integer(output.checkpoint_every_steps));
  checkpoint.add("every_wall_s", Value::of_number(output.checkpoint_every_wall_s));
  Value section = Value::mapping();
  section.add("trajectory", std::move(trajectory));
  section.add("fields", std::move(fields));
  section.add("checkpoint", std::move(checkpoint));
  section.add("wire", word(switch_names, output.wire));
  return section.add("trace", word(switch_names, output.trace));
}

ServicesCase read_services(Reader services) {
  ServicesCase result;
  {
    Reader fluid = services.section("fluid");
    const std::int64_t ranks = fluid.integer("ranks", Range::positive, 1);
    constexpr std::int64_t most_ranks = 1'000'000;
    if (ranks > most_ranks) {
      fluid.reject("ranks", "is " + std::to_string(ranks) + " (no machine has so many). Give the number of processes.");
    }
    result.fluid_ranks = static_cast<int>(std::min(ranks, most_ranks));
    result.fluid_command = fluid.command("command");
  }
  {
    Reader body = services.section("body");
    result.body_command = body.command("command");
  }
  result.transport = services.text("transport", "ipc");
  if (result.transport != "ipc" && result.transport != in_process_transport &&
      !result.transport.starts_with("tcp://")) {
    services.reject("transport", "is '" + result.transport +
                                     "' (known: ipc, tcp, in_process). Write ipc, tcp://host:port or in_process.");
  }
  result.connect_deadline_s = services.number("connect_deadline_s", Range::positive, 60.0);
  result.progress_deadline_s = services.number("progress_deadline_s", Range::positive, 60.0);
  return result;
}

Value resolved_services(const ServicesCase& services) {
  Value fluid = Value::mapping();
  fluid.add("ranks", Value::of_integer(services.fluid_ranks));
  fluid.add("command", Value::of_words(services.fluid_command));
  Value body = Value::mapping();
  body.add("command", Value::of_words(services.body_command));
  Value section = Value::mapping();
  section.add("fluid", std::move(fluid));
  section.add("body", std::move(body));
  section.add("transport", Value::of_text(services.transport));
  section.add("connect_deadline_s", Value::of_number(services.connect_deadline_s));
  return section.add("progress_deadline_s", Value::of_number(services.progress_deadline_s));
}

std::optional<Sweep> read_sweep(Reader& top) {
  if (!top.has("sweep")) return {};
  Reader sweep = top.section("sweep");
  Sweep result{sweep.text("key"), sweep.words("values")};
  if (result.values.empty()) {
    sweep.problems().error("sweep",
                           "sweep has no values (there is nothing to run). List them: values: [1.0e-6, 2.0e-6].");
  }
  return result;
}

BodyCase read_body_solver(Reader body) {
  BodyCase result;
  result.solver = read_solver(body, body_solver_names, std::optional(BodySolverChoice::own), result.command);
  result.integrator = body.choice("integrator", integrator_names, std::optional(Integrator::runge_kutta_4));
  return result;
}

/// Processes of fluid and bodies: a command in `services` (where --fluid and --body put theirs) takes
/// precedence over one in `solver`, and a solver without cells runs on one rank.
void settle_services(const FluidCase& fluid, const BodyCase& body, ServicesCase& services) {
  if (services.fluid_command.empty()) services.fluid_command = fluid.command;
  if (services.body_command.empty()) services.body_command = body.command;
  if (computes_no_cells(fluid.solver) && services.fluid_command.empty()) services.fluid_ranks = 1;
}

template <typename Item>
Value list(const std::vector<Item>& items, Value (*resolve)(const Item&)) {
  Value result = Value::sequence();
  for (const Item& item : items) result.add(resolve(item));
  return result;
}

}  // namespace

Case read_case(Reader top) {
  Case result;
  result.name = top.text("case");
  result.parameter_set = top.text("parameter_set", "");
  { top.section("parameter_sets").accept_all(); }
  result.fluid = read_fluid(top.section("fluid"));
  if (top.has("step_s")) result.given_step_s = top.number("step_s", Range::positive);
  result.body = read_body_solver(top.section("body"));
  for (std::size_t i = 0; i < top.size("swimmers"); ++i)
    result.swimmers.push_back(read_swimmer(top.item("swimmers", i)));
  for (std::size_t i = 0; i < top.size("bodies"); ++i) result.bodies.push_back(read_body(top.item("bodies", i)));
  for (std::size_t i = 0; i < top.size("springs"); ++i) result.springs.push_back(read_spring(top.item("springs", i)));
  for (std::size_t i = 0; i < top.size("forces"); ++i) result.forces.push_back(read_force(top.item("forces", i)));
  result.body.gravity_m_per_s2 = top.numbers("gravity_m_per_s2", 3, Eigen::VectorXd::Zero(3));
  {
    Reader coupling = top.section("coupling");
    coupling.choice("scheme", scheme_names, std::optional(SchemeKind::serial_explicit));
    result.load_averaging = coupling.choice("load_averaging", averaging_names, std::optional(LoadAveraging::two_step));
  }
  {
    Reader run = top.section("run");
    result.steps = run.integer("steps", Range::positive);
  }
  result.output = read_output(top.section("output"));
  result.services = read_services(top.section("services"));
  settle_services(result.fluid, result.body, result.services);
  result.sweep = read_sweep(top);
  return result;
}

Value resolved(const Case& the_case) {
  Value top = Value::mapping();
  top.add("case", Value::of_text(the_case.name));
  if (!the_case.parameter_set.empty()) top.add("parameter_set", Value::of_text(the_case.parameter_set));
  top.add("fluid", resolved_fluid(the_case.fluid));
  if (the_case.given_step_s) top.add("step_s", Value::of_number(*the_case.given_step_s));
  Value body = Value::mapping();
  body.add("solver", word(body_solver_names, the_case.body.solver));
  top.add("body", std::move(body.add("integrator", word(integrator_names, the_case.body.integrator))));
  top.add("swimmers", list(the_case.swimmers, resolved_swimmer));
  top.add("bodies", list(the_case.bodies, resolved_body));
  top.add("springs", list(the_case.springs, resolved_spring));
  top.add("forces", list(the_case.forces, resolved_force));
  top.add("gravity_m_per_s2", Value::of_vector(the_case.body.gravity_m_per_s2));
  Value coupling = Value::mapping();
  coupling.add("scheme", word(scheme_names, SchemeKind::serial_explicit));
  coupling.add("load_averaging", word(averaging_names, the_case.load_averaging));
  top.add("coupling", std::move(coupling));
  Value run = Value::mapping();
  top.add("run", std::move(run.add("steps", Value::of_integer(the_case.steps))));
  top.add("output", resolved_output(the_case.output));
  return top.add("services", resolved_services(the_case.services));
}

std::string case_key(Case the_case) {
  Digest digest;
  for (Swimmer& swimmer : the_case.swimmers) swimmer.published.clear();
  Value physics = resolved(the_case);
  std::erase_if(physics.entries, [](const Value::Entry& entry) {
    return entry.key == "run" || entry.key == "output" || entry.key == "services";
  });
  for (const char letter : to_yaml(physics)) digest.add(static_cast<std::uint64_t>(static_cast<unsigned char>(letter)));
  return std::to_string(digest.value());
}

namespace {

double derived_step_s(const Case& the_case) {
  if (the_case.given_step_s) return *the_case.given_step_s;
  const FluidCase& fluid = the_case.fluid;
  if (!fluid.relaxation_time || fluid.cell_size_m <= 0.0 || fluid.kinematic_viscosity_m2_per_s <= 0.0) return 0.0;
  return step_from_relaxation_time(*fluid.relaxation_time, fluid.cell_size_m, fluid.kinematic_viscosity_m2_per_s);
}

void refuse_campaign(const Document& document) {
  if (document.root().find("campaign") == nullptr) return;
  throw CaseInvalid(document.locate("campaign"),
                    "the file is a campaign (a list of cases). Run it with `copepod campaign`, or name one of its "
                    "cases.");
}

LoadedCase read_document(const Document& document, AskedKeys* asked) {
  refuse_campaign(document);
  Problems problems(document);
  LoadedCase loaded;
  loaded.content = read_case(Reader(&document.root(), "", problems, asked));
  loaded.content.step_s = derived_step_s(loaded.content);
  loaded.assembly = assemble(loaded.content);
  check_case(loaded.content, loaded.assembly, problems);
  problems.throw_if_any();
  loaded.warnings = problems.warnings();
  return loaded;
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
  setup.fields = the_case.output.fields;
  setup.fields.directory = field_directory;
  return setup;
}

BodySetup make_body_setup(const Case& the_case, const Assembly& assembly) {
  const FluidCase& fluid = the_case.fluid;
  BodySetup setup = static_cast<const BodySetup&>(the_case.body);
  setup.step_s = the_case.step_s;
  setup.fluid_density_kg_per_m3 = fluid.kind == FluidKind::vacuum ? 0.0 : fluid.density_kg_per_m3;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (fluid.boundaries[2 * axis].kind != BoundaryKind::periodic) continue;
    setup.periodic_length_m[axis] = static_cast<double>(fluid.domain_cells[axis]) * fluid.cell_size_m;
  }
  setup.bodies = assembly.bodies;
  setup.springs = assembly.springs;
  for (const DrivenActuator& driven : assembly.drive) setup.actuators.push_back(driven.actuator);
  return setup;
}

std::set<std::string> required_of_fluid(const Case& the_case, const Assembly& assembly) {
  std::set<std::string> required = required_features(make_fluid_setup(the_case, assembly, ""));
  if (the_case.fluid.solver == FluidSolverChoice::external) required = without_methods(std::move(required));
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
