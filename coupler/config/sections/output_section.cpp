#include <algorithm>
#include <regex>
#include <set>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "transport/endpoint.hpp"

// Section `output`.

namespace copepod::coupler {

namespace {

using nlohmann::ordered_json;

/// Start and stop along an axis; a single number is one layer of cells.
void declare_range(Keys& keys, const char* axis, std::int64_t& start, std::int64_t& stop) {
  const ordered_json cell = schema_of_integer(Range::not_negative);
  keys.describe(axis, {{"anyOf", {cell, schema_of_list(cell, 2)}}},
                "[start, stop): cells along an axis, the first has index 0; or the index of one layer of cells.");
  if (stop > 0) keys.write(axis, std::array{start, stop});
  const Value* given = keys.raw(axis);
  if (given == nullptr) return;
  if (given->kind == Value::Kind::scalar) {
    keys.integer(axis, start, Range::not_negative, "");
    stop = start + 1;
    return;
  }
  std::array<std::int64_t, 2> range{1, 1};
  keys.integers(axis, range, Range::not_negative, "");
  start = range[0];
  stop = range[1];
  keys.reject_if(start >= stop, axis,
                 "is [" + std::to_string(start) + ", " + std::to_string(stop) +
                     "] (no cell lies in it). Write [start, stop] with start < stop, or one number.");
}

/// Start and stop along x, y and z; empty if no axis is restricted.
void declare_region(Keys& keys, std::vector<std::int64_t>& region) {
  keys.section("region_cells",
               "Cells that are written, along each axis; without an axis: all cells along it. Example: {y: 50, z: "
               "[20, 80]} is a slice.",
               [&](Keys& axes) {
                 region.resize(6);
                 for (std::size_t axis = 0; axis < 3; ++axis)
                   declare_range(axes, axis_names[axis], region[2 * axis], region[2 * axis + 1]);
                 if (std::ranges::count(region, 0) == 6) region.clear();
               });
}

void declare_quantities(Keys& keys, std::vector<FieldQuantity>& quantities) {
  const char* key = "quantities";
  std::vector<std::string> words;
  words.reserve(quantities.size());
  for (const FieldQuantity quantity : quantities) words.emplace_back(name_of(quantity_names, quantity));
  keys.words(key, words, 0,
             "What is written of each cell, beside the body that covers it. pressure: relative to fluid at rest [Pa]; "
             "vorticity: curl of the velocity [1/s], zero in bodies. The flow picture of the report needs velocity. "
             "Default: [density, velocity].");
  ordered_json known = ordered_json::array();
  for (const Choice<FieldQuantity>& quantity : quantity_names) known.push_back(quantity.name);
  keys.describe_also(key, {{"items", {{"enum", known}}}, {"uniqueItems", true}});
  quantities.clear();
  for (const std::string& word : words) {
    const auto found = std::ranges::find(quantity_names, word, &Choice<FieldQuantity>::name);
    const bool is_known = found != quantity_names.end();
    const bool is_new = is_known && std::ranges::find(quantities, found->value) == quantities.end();
    keys.reject_if(!is_known, key, "names '" + word + "' (known: density, velocity, pressure, vorticity). Use these.");
    keys.reject_if(is_known && !is_new, key, "names " + word + " twice (once is enough). Remove one.");
    if (is_new) quantities.push_back(found->value);
  }
  if (quantities.empty()) quantities = {FieldQuantity::density, FieldQuantity::velocity};
}

/// A hundred frames, at steps that are in the trajectory too.
std::int64_t usual_steps_between_frames(std::int64_t steps, std::int64_t trajectory_every_steps) {
  constexpr std::int64_t frames = 100;
  const std::int64_t unit = std::max<std::int64_t>(trajectory_every_steps, 1);
  return std::max<std::int64_t>((steps + frames * unit - 1) / (frames * unit), 1) * unit;
}

void declare_fields(Keys& keys, FieldOutput& fields) {
  keys.integer("every_steps", fields.every_steps, Range::not_negative,
               "Steps between snapshots, the first of step 0; 0: none.");
  std::array mean{fields.mean_start, fields.mean_stop};
  keys.integers("mean_over_steps", mean, Range::not_negative,
                "[start, stop): steps over which the fields are averaged; [0, 0]: no mean.");
  fields.mean_start = mean[0];
  fields.mean_stop = mean[1];
  keys.integer("mean_every_steps", fields.mean_every_steps, Range::positive, "Steps between samples of the mean.");
  declare_quantities(keys, fields.quantities);
  declare_region(keys, fields.region_cells);
  keys.choice("compression", fields.compression, compression_names,
              "deflate: smaller files, the same numbers; one process compresses, about 100 MB/s.");
}

/// First step of which samples are evaluated.
void declare_from_step(Keys& keys, std::int64_t& from_step, std::int64_t steps) {
  if (keys.reads()) from_step = steps / 2;
  keys.integer({"from_step", Need::in_some_cases}, from_step, Range::not_negative,
               "First step that is evaluated. Default: half of run.steps.");
}

/// Those that are neither periodic nor symmetry planes.
std::vector<std::int64_t> faces_of(const FluidCase& fluid) {
  std::vector<std::int64_t> faces;
  for (std::size_t face = 0; face < fluid.boundaries.size(); ++face)
    if (fluid.boundaries[face].kind != BoundaryKind::periodic) faces.push_back(static_cast<std::int64_t>(face));
  return faces;
}

void declare_flow(Keys& keys, OutputCase& output, const FluidCase& fluid, std::int64_t steps) {
  FlowSampling& flow = output.flow;
  keys.integer("every_steps", flow.every_steps, Range::not_negative,
               "Steps between samples, the first of step 0; 0: none. Each is of the start of its step.");
  keys.flag("totals", flow.totals,
            "Kinetic energy, dissipation, enstrophy ½∫ω² dV and momentum of all fluid. They take as long as about ten "
            "steps.");
  bool has_faces = !flow.faces.empty();
  keys.flag("faces", has_faces,
            "Flow through each face of the domain that is not periodic, and the force of the fluid on it.");
  if (keys.reads() && has_faces) flow.faces = faces_of(fluid);
  if (keys.written_if(flow.every_steps > 0)) declare_from_step(keys, output.flow_from_step, steps);
  if (!keys.written_if(!flow.probes.empty())) return;
  keys.list("probes", flow.probes, "Places at which velocity and pressure are sampled, which costs next to nothing.",
            [](Keys& probe, Probe& item) {
              probe.name(required("name"), item.name, "Name of its columns.");
              probe.numbers(required("position_m"), item.position_m,
                            "Place in the domain [m]; values are linear between the centres of cells.");
            });
}

/// The direction of the first inflow, or suction; without one x.
Eigen::Vector3d stream_direction(const FluidCase& fluid) {
  for (std::size_t face = 0; face < fluid.boundaries.size(); ++face)
    if (fluid.boundaries[face].lets_in(face)) return fluid.boundaries[face].velocity_m_per_s.normalized();
  return Eigen::Vector3d::UnitX();
}

void declare_coefficients(Keys& item, Coefficients& each, const FluidCase& fluid, std::int64_t steps) {
  item.name(required("of"), each.of, "A body, or an obstacle with loads: true.");
  item.number(required("speed_m_per_s"), each.speed_m_per_s, Range::positive, "U, of the stream.");
  item.number(required("area_m2"), each.area_m2, Range::positive, "A, of the whole body also where it is mirrored.");
  item.number(required("length_m"), each.length_m, Range::positive, "L, such as the diameter.");
  if (item.reads()) each.drag_axis = stream_direction(fluid);
  declare_direction(item, {"drag_axis", Need::in_some_cases}, each.drag_axis,
                    "Direction of the drag; it is normalised. Default: that of the inflow, or x.");
  if (item.reads()) each.lift_axis = {each.drag_axis[2], each.drag_axis[0], each.drag_axis[1]};
  declare_direction(item, {"lift_axis", Need::in_some_cases}, each.lift_axis,
                    "Direction of the lift, across the drag; it is normalised. Default: y for a drag along x, z for y, "
                    "x for z.");
  declare_from_step(item, each.from_step, steps);
}

/// The sum of the fluid's ranks on all hosts, each "name" (one rank) or "name:ranks".
int ranks_of_hosts(Keys& services, const std::vector<std::string>& hosts) {
  static const std::regex form("([A-Za-z0-9][A-Za-z0-9_.-]*)(:([0-9]{1,5}))?");
  int ranks = 0;
  std::set<std::string> names;
  for (const std::string& host : hosts) {
    std::smatch parts;
    if (!std::regex_match(host, parts, form)) {
      services.reject("hosts", "has '" + host + "' (not a host). Write name, or name:ranks.");
    } else if (!names.insert(parts[1]).second) {
      services.reject("hosts", "has " + parts[1].str() + " twice (a host has one number of ranks). Write it once.");
    } else {
      ranks += parts[3].matched ? std::stoi(parts[3]) : 1;
    }
  }
  return ranks;
}

/// A number of processes or threads.
void declare_number_of(Keys& keys, const char* key, int& value, std::int64_t most, const std::string& problem,
                       const char* description) {
  std::int64_t number = value;
  keys.integer(key, number, Range::positive, description);
  keys.reject_if(number > most, key, "is " + std::to_string(number) + " (" + problem);
  value = static_cast<int>(std::min(number, most));
}

void check_transport(Keys& services, const std::string& transport) {
  const bool is_tcp = transport.starts_with("tcp://");
  services.reject_if(transport != "ipc" && transport != in_process_transport && !is_tcp, "transport",
                     "is '" + transport + "' (known: ipc, tcp, in_process). Write ipc, tcp://host:port or in_process.");
  try {
    if (is_tcp) transport::check_endpoint(transport);
  } catch (const CaseError& error) {
    services.problems().error(services.path_of("transport"), error.what());
  }
}

void settle_hosts(Keys& keys, ServicesCase& services) {
  if (services.hosts.empty()) return;
  services.fluid_ranks = ranks_of_hosts(keys, services.hosts);
  if (services.fluid_ranks == 0)
    keys.reject("hosts", "leaves the fluid without a rank. Give one of them ranks: name:ranks.");
  if (services.transport == in_process_transport)
    keys.reject("hosts", "needs processes (services.transport is in_process). Write transport: ipc.");
}

}  // namespace

void declare(Keys& keys, OutputCase& output, const FluidCase& fluid, std::int64_t steps) {
  keys.section("trajectory", "trajectory.csv or trajectory.npy.", [&](Keys& trajectory) {
    trajectory.integer("every_steps", output.trajectory_every_steps, Range::not_negative,
                       "Steps between samples; 0: only first and last step.");
    trajectory.integer("from_step", output.trajectory_from_step, Range::not_negative,
                       "No samples before this step, except the first.");
    trajectory.choice("format", output.trajectory_format, trajectory_format_names,
                      "csv: text, a row per body and sample; npy: an array of NumPy, with a field per quantity; auto: "
                      "csv up to 100 bodies. A resumed run keeps the form that it has.");
  });
  if (keys.reads()) output.bodies_every_steps = usual_steps_between_frames(steps, output.trajectory_every_steps);
  keys.section("bodies", "bodies.pvd: surfaces of the bodies over time, for ParaView.", [&](Keys& bodies) {
    bodies.integer({"every_steps", Need::in_some_cases}, output.bodies_every_steps, Range::not_negative,
                   "Steps between frames; first and last step have one too; 0: no files. Default: about 100 frames at "
                   "most, at steps that are in the trajectory.");
  });
  keys.section("fields", "fields.h5, with fields.xdmf (snapshots) and fields_mean.xdmf for ParaView.",
               [&](Keys& fields) { declare_fields(fields, output.fields); });
  keys.section("flow",
               "flow.csv: figures of the flow over time, with their means in summary.json. With solver: "
               "lattice_boltzmann.",
               [&](Keys& flow) { declare_flow(flow, output, fluid, steps); });
  if (keys.written_if(!output.coefficients.empty()))
    keys.list("coefficients", output.coefficients,
              "Drag and lift coefficients 2 F/(ρ U² A) over time in coefficients.csv, at the steps of the trajectory; "
              "their means and the Strouhal number f L/U in summary.json.",
              [&](Keys& item, Coefficients& each) { declare_coefficients(item, each, fluid, steps); });
  keys.section("checkpoint", "Restart points.", [&](Keys& checkpoint) {
    checkpoint.integer("every_steps", output.checkpoint_every_steps, Range::not_negative,
                       "Steps between checkpoints; 0: not by steps.");
    checkpoint.number("every_wall_s", output.checkpoint_every_wall_s, Range::not_negative,
                      "Wall time between checkpoints in seconds; 0: not by time.");
  });
  keys.flag(
      "wire", output.wire,
      "Record every message between coupler and components in wire/, for `copepod replay` and `copepod recording`.");
  keys.flag("trace", output.trace,
            "Record the phases of each process and rank in trace/, for `copepod recording trace`.");
}

void declare(Keys& keys, ServicesCase& services) {
  const char* command = "Words of the command that starts another component; empty: the built-in one.";
  keys.section("fluid", "The fluid service.", [&](Keys& fluid) {
    declare_number_of(fluid, "ranks", services.fluid_ranks, 1'000'000,
                      "no machine has so many). Give the number of processes.",
                      "Number of MPI processes. stokes and vacuum use one.");
    fluid.command("command", services.fluid_command, command);
    declare_parameters(fluid, services.fluid_parameters);
  });
  keys.section("body", "The body service.", [&](Keys& body) {
    body.command("command", services.body_command, command);
    declare_parameters(body, services.body_parameters);
    declare_number_of(
        body, "threads", services.body_threads, most_threads,
        "at most " + std::to_string(most_threads) + "). Use at most the number of cores.",
        "Threads in which our solver moves bodies that nothing joins; results do not depend on it. Worth it from some "
        "thousand bodies on, with a core that the fluid's ranks leave free. Other components ignore it.");
    body.describe_also("threads", {{"maximum", most_threads}});
  });
  keys.words("hosts", services.hosts, 0,
             "Hosts of the fluid's ranks: name (one rank) or name:ranks, instead of fluid.ranks. The first one runs "
             "the command, the coupler and the bodies. See docs/hosts.md. Default: this machine alone.");
  keys.describe_also("hosts",
                     {{"items", {{"type", "string"}, {"pattern", "^[A-Za-z0-9][A-Za-z0-9_.-]*(:[0-9]{1,5})?$"}}}});
  keys.text("transport", services.transport,
            "ipc, tcp://host:port, or in_process: coupler, our own bodies and fluid in one process, the ranks of the "
            "fluid as threads. Fastest for small cases.");
  keys.describe_also("transport", {{"pattern", "^(ipc|in_process|tcp://.+)$"}});
  if (keys.reads()) {
    check_transport(keys, services.transport);
    settle_hosts(keys, services);
    const bool has_network = services.transport.starts_with("tcp://") || !services.hosts.empty();
    services.silence_s = has_network ? 30.0 : 3.0;  // a network may be cut for a while
  }
  keys.number("connect_deadline_s", services.connect_deadline_s, Range::positive,
              "Maximum wait of the coupler for both components at the start.");
  keys.number(
      "progress_deadline_s", services.progress_deadline_s, Range::positive,
      "A component is considered hung if its step, phase and progress do not change for this long while work is due.");
  keys.number({"silence_s", Need::in_some_cases}, services.silence_s, Range::positive,
              "A component is considered frozen, or its host lost, if it does not answer for this long (default: 3, "
              "over tcp 30). A network may be cut for half of it.");
}

}  // namespace copepod::coupler
