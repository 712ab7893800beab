#include <algorithm>

#include <nlohmann/json.hpp>

#include "config/sections/sections.hpp"

namespace copepod::coupler {
namespace {

using nlohmann::ordered_json;

/// One face: a word, or {velocity_m_per_s: […]}, or {pressure_Pa: …}.
Boundary read_face(Reader& faces, const std::string& key) {
  Boundary boundary;
  const Value* value = faces.raw(key);
  if (value == nullptr || value->kind == Value::Kind::scalar) {
    boundary.kind = faces.choice(key, boundary_names, std::optional(BoundaryKind::no_slip));
    if (boundary.kind == BoundaryKind::velocity || boundary.kind == BoundaryKind::pressure) {
      const std::string name = name_of(boundary_names, boundary.kind);
      faces.reject(key, "is '" + name +
                            "' without a value (how much is open). Write {velocity_m_per_s: [x, y, z]} or "
                            "{pressure_Pa: p}.");
    }
    return boundary;
  }
  Reader face = faces.section(key);
  const bool moves = face.has("velocity_m_per_s");
  const bool presses = face.has("pressure_Pa");
  if (moves == presses) {
    faces.reject(key,
                 "needs exactly one condition (a wall with a velocity, or an opening with a pressure). Give "
                 "velocity_m_per_s or pressure_Pa.");
    return boundary;
  }
  boundary.kind = moves ? BoundaryKind::velocity : BoundaryKind::pressure;
  if (moves) boundary.velocity_m_per_s = face.numbers("velocity_m_per_s", 3);
  if (presses) boundary.pressure_Pa = face.number("pressure_Pa", Range::any);
  return boundary;
}

/// Both faces of an axis: one condition for both, or {low: …, high: …}.
void read_axis(Reader& boundaries, const std::string& axis, Boundary& low, Boundary& high) {
  const Value* value = boundaries.raw(axis);
  const bool two_sided = value != nullptr && (value->find("low") != nullptr || value->find("high") != nullptr);
  if (!two_sided) {
    low = high = read_face(boundaries, axis);
    return;
  }
  Reader faces = boundaries.section(axis);
  low = read_face(faces, "low");
  high = read_face(faces, "high");
}

std::array<bool, 3> read_symmetry_planes(Reader& fluid) {
  std::array<bool, 3> planes{};
  for (const std::string& word : fluid.words("symmetry_planes")) {
    const auto axis = std::find(axis_names.begin(), axis_names.end(), word);
    if (axis != axis_names.end()) {
      planes[static_cast<std::size_t>(axis - axis_names.begin())] = true;
    } else {
      fluid.reject("symmetry_planes", "contains '" + word + "' (planes are named after their normal). Use x, y or z.");
    }
  }
  return planes;
}

FluidKind fluid_kind(FluidSolverChoice choice) {
  switch (choice) {
    case FluidSolverChoice::stokes:
      return FluidKind::stokes;
    case FluidSolverChoice::vacuum:
      return FluidKind::vacuum;
    case FluidSolverChoice::external:  // receives everything that the case specifies for a lattice
    case FluidSolverChoice::lattice_boltzmann:
      break;
  }
  return FluidKind::lattice_boltzmann;
}

InitialFlow read_initial_flow(Reader flow) {
  InitialFlow result;
  result.kind = flow.choice("kind", initial_flow_names, std::optional(InitialFlowKind::rest));
  if (result.kind == InitialFlowKind::uniform) result.velocity_m_per_s = flow.numbers("velocity_m_per_s", 3);
  if (result.kind == InitialFlowKind::taylor_green)
    result.speed_m_per_s = flow.number("speed_m_per_s", Range::positive);
  return result;
}

ordered_json resolved_initial_flow(const InitialFlow& flow) {
  ordered_json section{{"kind", name_of(initial_flow_names, flow.kind)}};
  if (flow.kind == InitialFlowKind::uniform) section["velocity_m_per_s"] = flow.velocity_m_per_s;
  if (flow.kind == InitialFlowKind::taylor_green) section["speed_m_per_s"] = flow.speed_m_per_s;
  return section;
}

ordered_json resolved_face(const Boundary& boundary) {
  switch (boundary.kind) {
    case BoundaryKind::velocity:
      return {{"velocity_m_per_s", boundary.velocity_m_per_s}};
    case BoundaryKind::pressure:
      return {{"pressure_Pa", boundary.pressure_Pa}};
    default:
      return name_of(boundary_names, boundary.kind);
  }
}

ordered_json resolved_boundaries(const FluidCase& fluid) {
  ordered_json boundaries;
  for (std::size_t axis = 0; axis < 3; ++axis)
    boundaries[axis_names[axis]] = {{"low", resolved_face(fluid.boundaries[2 * axis])},
                                    {"high", resolved_face(fluid.boundaries[2 * axis + 1])}};
  return boundaries;
}

}  // namespace

FluidCase read_fluid(Reader fluid) {
  FluidCase result;
  result.solver = read_solver<FluidSolverChoice>(fluid, solver_names, std::nullopt, result.command);
  result.kind = fluid_kind(result.solver);
  const bool known = !fluid.problems().any_under(fluid.path_of("solver"));  // else no key is missing for sure
  const bool lattice = known && result.solver == FluidSolverChoice::lattice_boltzmann;
  const bool viscous = lattice || result.solver == FluidSolverChoice::stokes;
  const auto unless = [](bool required) { return required ? std::optional<double>() : std::optional(0.0); };
  result.density_kg_per_m3 =
      fluid.number("density_kg_per_m3", lattice ? Range::positive : Range::not_negative, unless(viscous));
  result.kinematic_viscosity_m2_per_s =
      fluid.number("kinematic_viscosity_m2_per_s", viscous ? Range::positive : Range::not_negative, unless(viscous));
  result.cell_size_m = fluid.number("cell_size_m", lattice ? Range::positive : Range::not_negative, unless(lattice));
  if (fluid.has("relaxation_time")) result.relaxation_time = fluid.number("relaxation_time", Range::positive);
  const auto cells = fluid.integers("domain_cells", 3, lattice ? Range::positive : Range::not_negative,
                                    lattice ? std::nullopt : std::optional(std::vector<std::int64_t>(3, 0)));
  std::copy(cells.begin(), cells.end(), result.domain_cells.begin());
  {
    Reader boundaries = fluid.section("boundaries");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      read_axis(boundaries, axis_names[axis], result.boundaries[2 * axis], result.boundaries[2 * axis + 1]);
    }
  }
  result.no_slip_plane = fluid.choice("no_slip_plane", plane_names, std::optional(-1));
  result.symmetry_planes = read_symmetry_planes(fluid);
  result.body_force_N_per_m3 = fluid.numbers("body_force_N_per_m3", 3, Eigen::VectorXd::Zero(3));
  result.initial_flow = read_initial_flow(fluid.section("initial_flow"));
  result.collision = fluid.choice("collision", collision_names, std::optional(CollisionKind::trt));
  result.moving_boundary =
      fluid.choice("moving_boundary", moving_boundary_names, std::optional(MovingBoundary::parabolic));
  result.refill = fluid.choice("refill", refill_names, std::optional(Refill::nonequilibrium));
  result.precision = fluid.choice("precision", precision_names, std::optional(Precision::double_precision));
  return result;
}

ordered_json resolved_fluid(const FluidCase& fluid) {
  ordered_json section{{"solver", name_of(solver_names, fluid.solver)},
                       {"density_kg_per_m3", fluid.density_kg_per_m3},
                       {"kinematic_viscosity_m2_per_s", fluid.kinematic_viscosity_m2_per_s},
                       {"cell_size_m", fluid.cell_size_m}};
  if (fluid.relaxation_time) section["relaxation_time"] = *fluid.relaxation_time;
  section["domain_cells"] = fluid.domain_cells;
  section["boundaries"] = resolved_boundaries(fluid);
  section["no_slip_plane"] = name_of(plane_names, fluid.no_slip_plane);
  section["symmetry_planes"] = ordered_json::array();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (fluid.symmetry_planes[axis]) section["symmetry_planes"].push_back(axis_names[axis]);
  }
  section["body_force_N_per_m3"] = fluid.body_force_N_per_m3;
  section["initial_flow"] = resolved_initial_flow(fluid.initial_flow);
  section["collision"] = name_of(collision_names, fluid.collision);
  section["moving_boundary"] = name_of(moving_boundary_names, fluid.moving_boundary);
  section["refill"] = name_of(refill_names, fluid.refill);
  section["precision"] = name_of(precision_names, fluid.precision);
  return section;
}

double step_from_relaxation_time(double relaxation_time, double cell_size_m, double viscosity_m2_per_s) {
  return (relaxation_time - 0.5) / 3.0 * cell_size_m * cell_size_m / viscosity_m2_per_s;
}

double relaxation_time_from_step(double step_s, double cell_size_m, double viscosity_m2_per_s) {
  return 0.5 + 3.0 * viscosity_m2_per_s * step_s / (cell_size_m * cell_size_m);
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
