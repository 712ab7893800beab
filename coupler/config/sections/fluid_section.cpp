#include <filesystem>
#include <numbers>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"
#include "config/yaml/keys.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// A table of one column, or what resolved cases have of it: a run does not depend on the file.
void declare_profile(Keys& keys, std::vector<double>& factors) {
  keys.describe("file", {{"type", "string"}},
                "CSV file with a column factor, relative to the case file: one row for each cell of the face, of which "
                "the later axis is the fastest (x: y0 z0, y0 z1, …). With symmetry_planes for the whole face, of which "
                "the lower half counts. The run keeps its content.");
  const auto rows = keys.has("file") ? read_csv_rows(keys, "file", {"factor"}, {}, CsvHeader::optional) : std::nullopt;
  if (rows)
    for (const std::vector<double>& row : rows->values) factors.push_back(row[0]);
  if (keys.has("file")) return;
  keys.reject_if(keys.reads() && keys.size("factors") == 0, "file",
                 "and factors are missing (one holds the profile). Write file: NAME.csv.");
  factors.resize(keys.reads() ? keys.size("factors") : factors.size());
  keys.numbers({"factors", Need::in_some_cases}, Eigen::Map<Eigen::VectorXd>(factors.data(), std::ssize(factors)),
               "The factors themselves, as resolved cases have them.");
}

/// {velocity_m_per_s: […], profile: …, signal: …}, or {pressure_Pa: …}, or {outflow: {}}.
void declare_condition(Keys& keys, Boundary& boundary, double step_s) {
  if (keys.when(boundary.kind == BoundaryKind::velocity)) {
    keys.numbers(
        keys.needed("velocity_m_per_s"), boundary.velocity_m_per_s,
        "Velocity of the wall; with a component through the face, of the fluid that comes in or goes out there.");
    const Value* profile = keys.raw("profile");
    const bool is_table =
        keys.reads() ? profile != nullptr && profile->kind == Value::Kind::mapping : !boundary.profile.empty();
    if (!is_table)
      keys.choice("profile", boundary.parabolic, profile_names,
                  "Of an inflow: uniform; parabolic: times 4 s(1 − s) along each axis that walls bound, with s from 0 "
                  "to 1 between them; beside one wall and a free_slip face, half of that parabola; {file: NAME.csv}: "
                  "times a factor of each cell.");
    if (keys.when(is_table)) keys.either("profile", [&](Keys& table) { declare_profile(table, boundary.profile); });
    keys.section<Signal>("signal", boundary.signal, "Factor of the velocity that varies in time. Default: 1.",
                         [&](Keys& below, Signal& signal) { declare(below, signal, step_s, {factor_of_velocities}); });
  }
  if (keys.when(boundary.kind == BoundaryKind::pressure))
    keys.number(keys.needed("pressure_Pa"), boundary.pressure_Pa, Range::any,
                "Pressure, relative to the fluid at rest.");
  if (keys.when(boundary.kind == BoundaryKind::outflow))
    keys.section(
        "outflow",
        "Where fluid and sound leave: {}, or the word outflow for the face. The pressure of the whole is drawn "
        "to that at rest.",
        [&](Keys& below) {
          below.choice("bodies", boundary.removes_bodies, leaving_names,
                       "end: the run ends, by name, when a body reaches the face; remove: bodies without "
                       "springs, joints and actuators leave the run one cell before it, and summary.json names them.");
        });
}

/// One face: a word, or a section with its condition.
void declare_face(Keys& keys, const char* key, Boundary& boundary, double step_s) {
  const Value* value = keys.raw(key);
  const auto has_value = [&] {
    return boundary.kind == BoundaryKind::velocity || boundary.kind == BoundaryKind::pressure ||
           boundary.removes_bodies;
  };
  if (keys.reads() ? value == nullptr || value->kind == Value::Kind::scalar : !has_value()) {
    keys.choice(key, boundary.kind, boundary_names, "");
    keys.reject_if(has_value(), key,
                   std::string("is '") + name_of(boundary_names, boundary.kind) +
                       "' without a value (how much is open). Write {velocity_m_per_s: [x, y, z]} or {pressure_Pa: "
                       "p}.");
    return;
  }
  keys.section(key, "", [&](Keys& face) {
    const bool moves = face.has("velocity_m_per_s"), presses = face.has("pressure_Pa"), lets_out = face.has("outflow");
    if (face.reads() && moves + presses + lets_out != 1)
      return keys.reject(key,
                         "needs exactly one condition (a wall or an inflow with a velocity, or an opening). Give "
                         "velocity_m_per_s, pressure_Pa or outflow.");
    if (face.reads())
      boundary.kind = moves ? BoundaryKind::velocity : presses ? BoundaryKind::pressure : BoundaryKind::outflow;
    declare_condition(face, boundary, step_s);
  });
}

ordered_json schema_of_face() {
  Boundary any;
  ordered_json condition = Keys::described([&](Keys& keys) { declare_condition(keys, any, 0.0); });
  condition["description"] = "A wall that moves, an inflow, or an opening.";
  return {{"anyOf", {{{"enum", {"no_slip", "periodic", "free_slip", "outflow"}}}, condition}}};
}

ordered_json schema_of_axis() {
  ordered_json faces = Keys::described([](Keys& keys) {
    keys.describe("low", schema_of_face(), "Face at the lower end of the axis. Default: no_slip.");
    keys.describe("high", schema_of_face(), "Face at the upper end of the axis. Default: no_slip.");
  });
  faces["description"] = "Low and high face separately.";
  ordered_json forms = schema_of_face();
  forms["anyOf"].push_back(faces);
  return forms;
}

/// Both faces of an axis: one condition for both, or {low: …, high: …}.
void declare_axis(Keys& keys, const char* axis, double step_s, Boundary& low, Boundary& high) {
  if (keys.describes())
    return keys.describe(axis, schema_of_axis(),
                         "Both faces normal to this axis, or low and high separately. Default: no_slip.");
  const Value* value = keys.raw(axis);
  if (keys.reads() && (value == nullptr || (value->find("low") == nullptr && value->find("high") == nullptr))) {
    declare_face(keys, axis, low, step_s);
    high = low;
    return;
  }
  keys.section(axis, "", [&](Keys& faces) {
    declare_face(faces, "low", low, step_s);
    declare_face(faces, "high", high, step_s);
  });
}

FluidKind fluid_kind(FluidSolverChoice choice) {
  if (choice == FluidSolverChoice::stokes) return FluidKind::stokes;
  if (choice == FluidSolverChoice::vacuum) return FluidKind::vacuum;
  return FluidKind::lattice_boltzmann;  // external: receives everything that the case specifies for a lattice
}

void declare(Keys& keys, InitialFlow& flow) {
  keys.choice("kind", flow.kind, initial_flow_names,
              "rest; uniform: one velocity; shear: linear between the only two walls of which one moves; taylor_green: "
              "U (cos kx sin ly, −(k/l) sin kx cos ly, 0), one wavelength along x and y, which are periodic; "
              "taylor_green_3d: U (sin kx cos ky cos kz, −cos kx sin ky cos kz, 0) in a cube, "
              "one wavelength along x, y and z, which are periodic or free_slip; file: cell by cell.");
  if (keys.when(flow.kind == InitialFlowKind::uniform))
    keys.numbers(keys.needed("velocity_m_per_s"), flow.velocity_m_per_s, "For kind: uniform.");
  const bool is_file = flow.kind == InitialFlowKind::file;
  if (keys.when(flow.kind >= InitialFlowKind::taylor_green && !is_file))
    keys.number(keys.needed("speed_m_per_s"), flow.speed_m_per_s, Range::positive,
                "For kind: taylor_green or taylor_green_3d, U.");
  if (!keys.when(is_file)) return;
  keys.text(keys.needed("file"), flow.file,
            "For kind: file: HDF5 file as output.fields writes it, relative to the case file, with a value for every "
            "cell of domain_cells; where symmetry_planes halve an axis, its lower half counts. velocity_m_per_s, and "
            "pressure_Pa or density_kg_per_m3 if there. The fluid reads it where it runs, and a resumed run no more.");
  if (keys.has("file") && !keys.has_errors("file"))
    flow.file = std::filesystem::absolute(file_beside_case(keys, "file")).lexically_normal();
  if (flow.group.empty()) flow.group = "newest";
  keys.text({"group", Need::in_some_cases}, flow.group,
            "For kind: file: a group of the file, step_000001000 or mean. Default: newest, the one of its last step.");
}

void declare_symmetry_planes(Keys& keys, std::array<bool, 3>& planes) {
  const char* key = "symmetry_planes";
  std::vector<std::string> words;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (planes[axis]) words.emplace_back(axis_names[axis]);
  keys.words(key, words, 0,
             "Mirror planes through the middle of the domain, named after their normal. Only a half, quarter or eighth "
             "is computed; all input and output is for the whole domain. A body is centred on the plane, or lies "
             "entirely in the lower half, where it also represents its mirror image.");
  keys.describe_also(key, {{"items", {{"enum", axis_names}}}, {"uniqueItems", true}});
  for (std::size_t axis = 0; axis < 3; ++axis) planes[axis] = std::erase(words, axis_names[axis]) > 0;
  for (const std::string& word : words)
    keys.reject_if(true, key, "contains '" + word + "' (planes are named after their normal). Use x, y or z.");
}

}  // namespace

void declare(Keys& keys, FluidCase& fluid, std::optional<double> given_step_s) {
  declare_solver(
      keys, required("solver"), fluid.solver, solver_names, fluid.command, fluid.parameters,
      "lattice_boltzmann: D3Q19; stokes: quasi-steady flow around spheres by mobility; vacuum: no fluid; {command: …}: "
      "your own component. Changing this line swaps the solver: keys that it does not use are ignored.");
  fluid.kind = fluid_kind(fluid.solver);
  const bool known = keys.reads() && !keys.has_errors("solver");  // where it cannot be used, no key is missing for sure
  const bool lattice = known && fluid.solver == FluidSolverChoice::lattice_boltzmann;
  const bool viscous = lattice || (known && fluid.solver == FluidSolverChoice::stokes);
  const auto above_zero = [](bool needed) { return needed ? Range::positive : Range::not_negative; };
  keys.number(keys.needed("density_kg_per_m3", viscous), fluid.density_kg_per_m3, above_zero(lattice),
              "Density of the fluid.");
  keys.number(keys.needed("kinematic_viscosity_m2_per_s", viscous), fluid.kinematic_viscosity_m2_per_s,
              above_zero(viscous), "Kinematic viscosity of the fluid.");
  keys.number(keys.needed("cell_size_m", lattice), fluid.cell_size_m, above_zero(lattice),
              "Edge length of a lattice cell. Without a lattice: only the unit of results reported in cells.");
  keys.number("relaxation_time", fluid.relaxation_time, Range::positive,
              "Relaxation time τ of the collision, in steps; the step follows from it for every solver: Δt = (τ − 1/2) "
              "Δx² / (3 ν). Give this or step_s.");
  keys.integers(keys.needed("domain_cells", lattice), fluid.domain_cells, above_zero(lattice),
                "Cells along x, y and z of the whole domain, even with symmetry planes.");
  keys.section("boundaries", "Condition on the faces of the domain, by axis.", [&](Keys& boundaries) {
    const double step_s = step_of(fluid, given_step_s);
    for (std::size_t axis = 0; axis < 3; ++axis)
      declare_axis(boundaries, axis_names[axis], step_s, fluid.boundaries[2 * axis], fluid.boundaries[2 * axis + 1]);
  });
  keys.choice("no_slip_plane", fluid.no_slip_plane, plane_names,
              "With solver: stokes, the one face of the domain that is a wall; the flow is otherwise unbounded. Other "
              "solvers take their walls from boundaries.");
  declare_symmetry_planes(keys, fluid.symmetry_planes);
  keys.numbers(
      "body_force_N_per_m3", fluid.body_force_N_per_m3,
      "Constant force on the fluid alone: bodies do not feel the pressure gradient that it stands for, and a neutral "
      "sphere of 0.6 of a slit's width moves 9 % slower than between two faces with pressure_Pa. Where all faces are "
      "periodic, or mirrors, and no body is held, nothing takes it up: fluid and bodies accelerate for ever.");
  keys.section("initial_flow", "Flow before step 0, with its pressure. Default: at rest.",
               [&](Keys& flow) { declare(flow, fluid.initial_flow); });
  keys.choice(
      "collision", fluid.collision, collision_names,
      "trt: two relaxation times with Λ = 3/16, so that walls do not move with the relaxation time; bgk: one "
      "relaxation time (the paper's); central_moments: stable at low viscosity, for Reynolds numbers above 8 per "
      "cell, where surfaces are less accurate (docs/flows.md).");
  keys.choice("moving_boundary", fluid.moving_boundary, moving_boundary_names,
              "Where along a link a body's surface acts: bounce_back: half-way (the paper's; loads lack ρVω×v, so that "
              "the lift on bodies that move and turn has the wrong sign, −0.7 of Rubinow and Keller's); interpolated: "
              "at the surface, by linear interpolation (Bouzidi et al. 2001); central_linear: at the surface, by "
              "central linear interpolation (Ginzburg et al. 2008), with trt at the same place for every relaxation "
              "time; parabolic: the same, as a parabola through the surface, which is more accurate and quieter.");
  keys.choice(
      "refill", fluid.refill, refill_names,
      "Populations of uncovered cells: equilibrium: with the surface's velocity and the neighbours' density (the "
      "paper's); nonequilibrium: and the mean non-equilibrium part of the neighbours; grad: and their mean stress.");
  keys.choice("precision", fluid.precision, precision_names, "Storage and arithmetic of the populations.");
}

double step_from_relaxation_time(double relaxation_time, double cell_size_m, double viscosity_m2_per_s) {
  return (relaxation_time - 0.5) / 3.0 * cell_size_m * cell_size_m / viscosity_m2_per_s;
}

double step_of(const FluidCase& fluid, std::optional<double> given_step_s) {
  if (given_step_s) return *given_step_s;
  if (!fluid.relaxation_time || fluid.cell_size_m <= 0.0 || fluid.kinematic_viscosity_m2_per_s <= 0.0) return 0.0;
  return step_from_relaxation_time(*fluid.relaxation_time, fluid.cell_size_m, fluid.kinematic_viscosity_m2_per_s);
}

double relaxation_time_from_step(double step_s, double cell_size_m, double viscosity_m2_per_s) {
  return 0.5 + 3.0 * viscosity_m2_per_s * step_s / (cell_size_m * cell_size_m);
}

double relaxation_time(const Case& the_case) {
  const FluidCase& fluid = the_case.fluid;
  return relaxation_time_from_step(the_case.step_s, fluid.cell_size_m, fluid.kinematic_viscosity_m2_per_s);
}

double stokes_drag_kg_per_s(double radius_m, const FluidSetup& fluid) {
  const double viscosity_Pa_s = fluid.density_kg_per_m3 * fluid.kinematic_viscosity_m2_per_s;
  return 6.0 * std::numbers::pi * viscosity_Pa_s * radius_m;
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
