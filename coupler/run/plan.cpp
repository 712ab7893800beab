#include <array>
#include <cmath>
#include <map>
#include <tuple>

#include <Eigen/Eigenvalues>
#include <nlohmann/json.hpp>
#include <spdlog/fmt/bin_to_hex.h>
#include <spdlog/fmt/fmt.h>

#include "analysis/cycle_observer.hpp"
#include "analysis/swimmer_figures.hpp"
#include "config/checks/checks.hpp"
#include "config/sections/sections.hpp"
#include "config/setups.hpp"
#include "config/yaml/document.hpp"
#include "contract/features.hpp"
#include "conversion/codec.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/shapes/solid.hpp"
#include "run/program.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

ordered_json command(const std::vector<std::string>& words) {
  return words.empty() ? ordered_json(nullptr) : ordered_json(words);
}

void note(ordered_json& notes, const std::string& what, double value) {
  notes.push_back({{"what", what}, {"value", fmt::format("{:.4g}", value)}});
}

/// A note for each value, with the names of the bodies that have it in place of {}.
void note_alike(ordered_json& notes, const char* what, const std::map<std::string, std::vector<std::string>>& alike) {
  for (const auto& [value, names] : alike) {
    const std::string others = names.size() > 1 ? fmt::format(" and {} more", names.size() - 1) : "";
    notes.push_back({{"what", fmt::format(fmt::runtime(what), names.front() + others)}, {"value", value}});
  }
}

/// Virtual masses by the rule or the case; bodies that are alike share a note.
void note_virtual_masses(ordered_json& notes, const LoadedCase& loaded) {
  const Case& the_case = loaded.content;
  const std::vector<double> masses_kg = virtual_masses(the_case, loaded.assembly).mass_kg;
  std::map<std::string, std::vector<std::string>> alike;
  for (std::size_t i = 0; i < masses_kg.size(); ++i) {
    if (masses_kg[i] == 0.0) continue;
    const BodySpecification& body = loaded.assembly.bodies[i];
    const double ratio = mass_ratio(body, the_case.fluid);
    std::string value = fmt::format("{:.3g} (own mass {:.3g}", masses_kg[i] / body.mass_kg * ratio, ratio);
    if (!the_case.virtual_mass && on_lattice(the_case))
      value += fmt::format("; none is needed from {:.2g}", virtual_mass_rule(body, the_case).needed_below);
    alike[value + ")"].push_back(body.name);
  }
  note_alike(notes, "virtual mass of {} [displaced masses]", alike);
}

/// What follows from the shapes of bodies that are neither spheres nor capsules; bodies that are alike share a note.
void note_shapes(ordered_json& notes, const LoadedCase& loaded) {
  std::map<std::string, std::vector<std::string>> alike;
  for (const BodySpecification& body : loaded.assembly.bodies) {
    const Shape& shape = body.shape;
    if (is_round(shape)) continue;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia_tensor_kg_m2(body));
    const Eigen::Vector3d& moments_kg_m2 = principal.eigenvalues();
    std::string value =
        fmt::format("{}, {:.4g} m³, {:.4g} kg, principal moments {:.4g}, {:.4g}, {:.4g} kg m²", word_of(shape),
                    volume_m3(shape), body.mass_kg, moments_kg_m2[0], moments_kg_m2[1], moments_kg_m2[2]);
    if (loaded.content.fluid.cell_size_m > 0.0)
      value += fmt::format(", {:.3g} cells thick", thickness_m(shape) / loaded.content.fluid.cell_size_m);
    if (shape.kind == ShapeKind::mesh) value += fmt::format(", {} triangles", shape.mesh->triangles.cols());
    if (loaded.content.fluid.film_thickness_m > 0.0) value += ", no thin films";
    alike[value].push_back(body.name);
  }
  note_alike(notes, "shape of {}", alike);
}

/// What the bodies make of `contact`.
void note_contacts(ordered_json& notes, const LoadedCase& loaded) {
  const BodySetup setup = make_body_setup(loaded.content, loaded.assembly);
  if (setup.contact.stiffness_N_per_m == 0.0) return;
  const ExpectedContacts expected = expected_contacts(loaded.content, loaded.assembly);
  const double overlap_m = expected.overlap_m(setup.contact.stiffness_N_per_m);
  notes.push_back(
      {{"what", "stiffness of contacts [N/m]"},
       {"value", fmt::format("{:.4g} (overlap up to about {:.2g} of the smallest radius, {:.0f} substeps per step)",
                             setup.contact.stiffness_N_per_m, overlap_m / expected.smallest_radius_m,
                             contact_substeps(setup))}});
}

/// Figures of interest before a long run.
ordered_json make_notes(const LoadedCase& loaded) {
  const Case& the_case = loaded.content;
  ordered_json notes = ordered_json::array();
  note(notes, "step [s]", the_case.step_s);
  const FluidCase& fluid = the_case.fluid;
  if (on_lattice(the_case)) {
    note(notes, "relaxation time", fluid.relaxation_time.value_or(relaxation_time(the_case)));
    note(notes, "viscosity [cells^2/step]",
         fluid.kinematic_viscosity_m2_per_s * the_case.step_s / (fluid.cell_size_m * fluid.cell_size_m));
  }
  for (const Swimmer& swimmer : the_case.swimmers) {
    if (!swimmer.three_beads) continue;
    const Arm& arm = swimmer.arms[0];
    // D = γ / (2 √(m k))   [paper, eq. (11)]
    note(notes, "damping ratio of " + swimmer.name,
         arm.damping_N_s_per_m / (2.0 * std::sqrt(swimmer.beads[0].mass_kg * arm.stiffness_N_per_m)));
    if (fluid.cell_size_m > 0.0)
      note(notes, "rest length of " + swimmer.name + " [cells]", rest_length_m(swimmer) / fluid.cell_size_m);
  }
  note_shapes(notes, loaded);
  note_virtual_masses(notes, loaded);
  note_contacts(notes, loaded);
  return notes;
}

/// The swept keys, and for each member their values and what to --set.
ordered_json plan_of(const Sweep& sweep) {
  ordered_json parameters = ordered_json::array();
  for (const SweptKey& parameter : sweep.parameters)
    parameters.push_back({{"key", parameter.key}, {"scale", name_of(scale_names, parameter.scale)}});
  ordered_json members = ordered_json::array();
  for (std::size_t member = 0; member < member_count(sweep); ++member) {
    ordered_json values = ordered_json::array();
    ordered_json settings = ordered_json::array();
    for (const Value::Entry& assignment : assignments_of(sweep, member)) {
      settings.push_back(setting_text(assignment));
      if (values.size() < sweep.parameters.size()) values.push_back(to_json(assignment.value, Scalars::as_numbers));
    }
    members.push_back({{"values", values}, {"set", settings}});
  }
  return {{"combine", name_of(combination_names, sweep.combination)}, {"parameters", parameters}, {"members", members}};
}

/// What a component has to announce: {"springs": ["neglects:springs", "springs"], …}, any of the list for each. Bodies
/// that lack an actuator may be driven by those fixed in the world, but for what moves a joint.
ordered_json with_accepted(const std::set<std::string>& features) {
  ordered_json accepted = ordered_json::object();
  const bool lowers = !features.contains("actuator:joint_motion");
  for (const std::string& name : features) {
    std::set<std::string> names = accepted_for(name);
    if (lowers && name.starts_with("actuator:")) names.insert({"actuator:world_force", "actuator:world_torque"});
    accepted[name] = names;
  }
  return accepted;
}

/// The setup that a component receives, for its `--estimate`.
template <class Setup>
std::string in_hex(const Setup& setup) {
  return fmt::format("{:spn}", spdlog::to_hex(conversion::to_bytes(setup)));
}

/// Peak resident memory of the coupler's own process [bytes]; components estimate theirs (`--estimate`).
/// Measured with Debian 12 [docs/results/memory.md].
std::int64_t coupler_bytes(const Case& the_case) {
  constexpr std::int64_t mebibyte = std::int64_t{1} << 20;
  const bool saves = the_case.output.checkpoint_every_steps > 0;
  if (the_case.services.transport == in_process_transport)  // fluid and bodies included, but not the cells
    return (saves && on_lattice(the_case) ? 22 : 18) * mebibyte;
  return (saves ? 13 : 12) * mebibyte;
}

/// Of one snapshot or mean, uncompressed [bytes].
std::int64_t field_bytes(const Case& the_case) {
  if (!on_lattice(the_case)) return 0;
  const FieldOutput& fields = the_case.output.fields;
  std::int64_t bytes = sizeof(std::int32_t);  // of a cell: the body that covers it
  for (const FieldQuantity quantity : fields.quantities) {
    const bool is_vector = quantity == FieldQuantity::velocity || quantity == FieldQuantity::vorticity;
    bytes += (is_vector ? 3 : 1) * std::int64_t{sizeof(double)};
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const bool restricted = !fields.region_cells.empty() && fields.region_cells[2 * axis + 1] > 0;
    bytes *= restricted ? fields.region_cells[2 * axis + 1] - fields.region_cells[2 * axis]
                        : the_case.fluid.domain_cells[axis];
  }
  return bytes;
}

/// What the run directory will hold, at most [bytes].
ordered_json disk_bytes(const Case& the_case, std::int64_t bodies) {
  const bool is_text = the_case.output.trajectory_format == TrajectoryFormat::csv;
  const std::int64_t row_bytes = is_text ? 400 : 176;                // of a body; in text all digits are in use
  const std::int64_t surface_bytes = bodies <= 30 ? 10'000 : 2'600;  // of a body in a frame of bodies.pvd
  constexpr std::int64_t kept_checkpoints = 3;                       // two, and one that is being written
  const OutputCase& output = the_case.output;
  const auto times_of = [&](std::int64_t every, std::int64_t from) {
    return every == 0 || from > the_case.steps ? 0 : (the_case.steps - from) / every + 1;
  };
  const std::int64_t fields = times_of(output.fields.every_steps, 0) + (output.fields.mean_stop > 0 ? 1 : 0);
  const bool saves = output.checkpoint_every_steps > 0 || output.checkpoint_every_wall_s > 0.0;
  const std::int64_t rows = bodies + std::ranges::count(the_case.fluid.obstacles, true, &ObstacleSpecification::loads);
  return {{"trajectory", times_of(output.trajectory_every_steps, output.trajectory_from_step) * rows * row_bytes},
          {"bodies", times_of(output.bodies_every_steps, 0) * bodies * surface_bytes},
          {"fields", fields * field_bytes(the_case)},
          {"checkpoints", saves ? kept_checkpoints * population_bytes(the_case.fluid) : 0}};
}

/// Closed surface of triangles, as pages draw it: points in the shape's frame are multiples of `unit_m`. Only spheres
/// and capsules have a radius.
ordered_json surface_of(const Shape& shape, int around) {
  constexpr std::size_t most_triangles = 20'000;
  const auto solid = make_solid(shape);
  const Surface surface = solid->surface(around);
  const double unit_m = solid->bounding_radius() / (surface.strip.size() > 3 * most_triangles ? 50.0 : 10'000.0);
  std::map<std::array<long, 3>, int> numbers;
  std::vector<long> points;
  const auto number_of = [&](std::int32_t point) {
    const auto multiple = [&](int axis) { return std::lround(surface.points(axis, point) / unit_m); };
    const std::array place{multiple(0), multiple(1), multiple(2)};
    const auto [entry, is_new] = numbers.try_emplace(place, static_cast<int>(numbers.size()));
    if (is_new) points.insert(points.end(), place.begin(), place.end());
    return entry->second;
  };
  std::vector<int> triangles;
  surface.for_each_triangle([&](std::int32_t a, std::int32_t b, std::int32_t c) {
    const std::array corners{number_of(a), number_of(b), number_of(c)};
    if (corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0])
      triangles.insert(triangles.end(), corners.begin(), corners.end());
  });
  const ordered_json radius_m = is_round(shape) ? ordered_json(shape.radius_m) : ordered_json(nullptr);
  return {{"radius_m", radius_m}, {"unit_m", unit_m}, {"points", points}, {"triangles", triangles}};
}

}  // namespace

ordered_json make_plan(const LoadedCase& loaded, Beginning beginning) {
  const Case& the_case = loaded.content;
  const ordered_json tree = resolved(the_case);
  const std::int64_t cells = computed_cells(the_case.fluid);
  ordered_json plan;
  plan["case"] = tree;
  plan["case_yaml"] = to_yaml(tree);
  plan["name"] = the_case.name;
  plan["steps"] = the_case.steps;
  plan["services"] = {
      {"fluid", {{"ranks", the_case.services.fluid_ranks}, {"command", command(the_case.services.fluid_command)}}},
      {"body",
       {{"solver", name_of(body_solver_names, the_case.body.solver)},
        {"command", command(the_case.services.body_command)}}},
      {"hosts", the_case.services.hosts},
      {"transport", the_case.services.transport},
      {"silence_s", the_case.services.silence_s}};
  plan["controllers"] = ordered_json::object();
  for (const ControllerCase& each : the_case.controllers) plan["controllers"][each.name] = each.command;
  plan["requires"] = {{"fluid", with_accepted(required_of_fluid(the_case, loaded.assembly))},
                      {"body", with_accepted(required_of_body(the_case, make_body_setup(the_case, loaded.assembly)))}};
  FluidSetup fluid = make_fluid_setup(the_case, loaded.assembly, "");
  if (beginning != Beginning::fresh) fluid.initial_flow = {};  // that of a checkpoint replaces it
  plan["setups"] = {{"fluid", in_hex(fluid)}, {"body", in_hex(make_body_setup(the_case, loaded.assembly))}};
  plan["estimate"] = {{"cells", cells},
                      {"memory_of", {{"coupler_bytes", coupler_bytes(the_case)}}},
                      {"bodies", loaded.assembly.bodies.size()},
                      {"disk_bytes", disk_bytes(the_case, static_cast<std::int64_t>(loaded.assembly.bodies.size()))},
                      {"cell_updates", static_cast<double>(cells) * static_cast<double>(the_case.steps)}};
  plan["warnings"] = loaded.warnings;
  if (the_case.until_periodic && !have_cycles(groups_of(the_case, loaded.assembly))) {
    plan["warnings"].push_back(
        "warning: run.until_periodic has no effect (nothing in the case has a period: the run takes all its steps). "
        "Give a swimmer a stroke, or a group period_steps.");
  }
  plan["notes"] = make_notes(loaded);
  if (loaded.sweep) plan["sweep"] = plan_of(*loaded.sweep);
  return plan;
}

ordered_json make_campaign_plan(const Campaign& campaign) {
  ordered_json cases = ordered_json::array();
  for (const CampaignEntry& entry : campaign.cases)
    cases.push_back({{"name", entry.name}, {"file", entry.case_file}, {"set", entry.settings}});
  return {{"name", campaign.name},
          {"jobs", campaign.jobs > 0 ? ordered_json(campaign.jobs) : ordered_json(nullptr)},
          {"cases", cases}};
}

ordered_json surfaces_of(const LoadedCase& loaded) {
  const std::vector<BodySpecification>& bodies = loaded.assembly.bodies;
  const int around = bodies.size() <= 30 ? 40 : 12;
  ordered_json surfaces = ordered_json::array();
  std::map<std::tuple<ShapeKind, double, double, double, double, double>, std::size_t> numbers;
  const auto number_of = [&](const Shape& shape) {
    const Eigen::Vector3d& extents_m = shape.extents_m;
    if (shape.mesh != nullptr || !shape.parts.empty()) {
      surfaces.push_back(surface_of(shape, around));
      return surfaces.size() - 1;
    }
    const auto [entry, is_new] = numbers.try_emplace(
        {shape.kind, shape.radius_m, shape.length_m, extents_m[0], extents_m[1], extents_m[2]}, surfaces.size());
    if (is_new) surfaces.push_back(surface_of(shape, around));
    return entry->second;
  };
  ordered_json by_body = ordered_json::object();
  for (const BodySpecification& body : bodies) by_body[body.name] = number_of(body.shape);
  ordered_json obstacles = ordered_json::array();
  for (const ObstacleSpecification& obstacle : loaded.content.fluid.obstacles)
    obstacles.push_back({{"surface", number_of(obstacle.shape)},
                         {"position_m", obstacle.position_m},
                         {"orientation_wxyz", obstacle.orientation_wxyz}});
  return {{"surfaces", surfaces}, {"bodies", by_body}, {"obstacles", obstacles}};
}

}  // namespace copepod::coupler
