#include <algorithm>
#include <optional>

#include <spdlog/fmt/fmt.h>

#include "config/checks/checks.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

namespace {

const char* time_key(const Case& the_case) {
  return the_case.fluid.relaxation_time ? "fluid.relaxation_time" : "step_s";
}

bool has_walls(const FluidCase& fluid) {
  for (std::size_t face = 0; face < 6; ++face)
    if (fluid.boundaries[face].is_wall(face)) return true;
  return false;
}

void check_cell_reynolds(const FluidCase& fluid, double speed_m_per_s, const std::string& path, Problems& problems) {
  const double reynolds = speed_m_per_s * fluid.cell_size_m / fluid.kinematic_viscosity_m2_per_s;
  if (fluid.collision != CollisionKind::central_moments && reynolds > 8.0)
    problems.warn(path, "is a flow with a Reynolds number of " + rounded_text(reynolds) +
                            " per cell (with collision: trt or bgk flows diverge above about 10). Use collision: "
                            "central_moments or smaller cells.");
}

void check_open_faces(const FluidCase& fluid, Problems& problems) {
  bool has_opening = false;
  std::optional<std::size_t> inflow;
  for (std::size_t face = 0; face < 6; ++face) {
    const Boundary& boundary = fluid.boundaries[face];
    has_opening = has_opening || boundary.kind == BoundaryKind::pressure || boundary.kind == BoundaryKind::outflow;
    if (boundary.lets_in(face)) inflow = face;
    if (boundary.lets_in(face)) check_cell_reynolds(fluid, boundary.largest_speed(), face_path(face), problems);
    const std::int64_t cells = fluid.domain_cells[(face / 2 + 1) % 3] * fluid.domain_cells[(face / 2 + 2) % 3];
    if (!boundary.profile.empty() && std::ssize(boundary.profile) != cells)
      problems.reject(face_path(face) + ".profile", "has " + std::to_string(boundary.profile.size()) +
                                                        " factors, the face " + std::to_string(cells) +
                                                        " cells (each has its own). Give as many.");
    if ((boundary.parabolic || !boundary.profile.empty()) && !boundary.lets_in(face))
      problems.reject(face_path(face),
                      "has a profile and no velocity through the face (a wall moves as a whole). Give "
                      "velocity_m_per_s a component along " +
                          std::string(axis_names[face / 2]) + ", or leave the profile out.");
  }
  if (has_opening || !inflow) return;
  problems.reject(face_path(*inflow),
                  "has a velocity through the face, and no face is open (the density would change without end). Give "
                  "another one outflow or pressure_Pa.");
}

/// A flow that the faces of the domain would destroy at once.
void check_initial_flow(const FluidCase& fluid, Problems& problems) {
  const std::string path = "fluid.initial_flow.kind";
  check_cell_reynolds(fluid, fluid.initial_flow.speed_m_per_s, path, problems);
  const auto& cells = fluid.domain_cells;
  if (fluid.initial_flow.kind == InitialFlowKind::taylor_green &&
      (fluid.boundaries[0].kind != BoundaryKind::periodic || fluid.boundaries[2].kind != BoundaryKind::periodic)) {
    problems.reject(path,
                    "is taylor_green, and x or y is not periodic (a vortex pair fills the domain along both, and no "
                    "wall is in its way). Make x and y periodic.");
  }
  const auto passes = [](const Boundary& boundary) {
    return boundary.kind == BoundaryKind::periodic || boundary.kind == BoundaryKind::free_slip;
  };
  if (fluid.initial_flow.kind == InitialFlowKind::taylor_green_3d &&
      (!std::ranges::all_of(fluid.boundaries, passes) || cells[0] != cells[1] || cells[0] != cells[2])) {
    problems.reject(path,
                    "is taylor_green_3d, and the domain is not a cube of which all faces are periodic or free_slip "
                    "(one wavelength fills each axis). Make x, y and z alike, of as many cells.");
  }
  if (fluid.initial_flow.kind != InitialFlowKind::shear) return;
  int moving = 0, between_walls = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Boundary& low = fluid.boundaries[2 * axis];
    const Boundary& high = fluid.boundaries[2 * axis + 1];
    if (low.kind != BoundaryKind::velocity && high.kind != BoundaryKind::velocity) continue;
    ++moving;
    if (low.is_wall(2 * axis) && high.is_wall(2 * axis + 1)) ++between_walls;
  }
  if (moving == 1 && between_walls == 1) return;
  problems.reject(path, "is shear, and " + std::to_string(between_walls) +
                            " axes lie between two walls that move along themselves (a flow linear between two walls "
                            "needs one such axis and no other wall that moves). Give one axis velocity_m_per_s.");
}

/// Steady forces on fluid and bodies together where no wall, obstacle, open face, joint or held body takes them up [N].
Eigen::Vector3d net_force_N(const Case& the_case, const Assembly& assembly) {
  const FluidCase& fluid = the_case.fluid;
  if (!fluid.obstacles.empty()) return Eigen::Vector3d::Zero();
  double fluid_m3 = fluid.length_m().prod();
  Eigen::Vector3d force_N = Eigen::Vector3d::Zero();
  for (const BodySpecification& body : assembly.bodies) {
    if (!moves_under_loads(body)) return Eigen::Vector3d::Zero();
    const double displaced_m3 = volume_m3(body.shape);
    force_N += (body.mass_kg - fluid.density_kg_per_m3 * displaced_m3) * the_case.body.gravity_m_per_s2;
    fluid_m3 -= displaced_m3;
  }
  force_N += fluid_m3 * fluid.body_force_N_per_m3;
  for (const auto& [actuator, signal] : assembly.drive)
    if (actuator.kind == ActuatorKind::world_force && signal.kind == SignalKind::constant)
      force_N += signal.amplitude * actuator.direction;
  for (std::size_t face = 0; face < 6; ++face) {
    const BoundaryKind kind = fluid.boundaries[face].kind;
    if (kind == BoundaryKind::free_slip)
      force_N[face / 2] = 0.0;
    else if (kind != BoundaryKind::periodic)
      return Eigen::Vector3d::Zero();
  }
  const auto to_the_world = [](const auto& link) { return std::min(link.body_A, link.body_B) < 0; };
  const bool held =
      std::ranges::any_of(assembly.joints, to_the_world) || std::ranges::any_of(assembly.springs, to_the_world);
  return held ? Eigen::Vector3d::Zero() : force_N;
}

}  // namespace

void check_time(const Case& the_case, Problems& problems) {
  const bool both = the_case.fluid.relaxation_time && the_case.given_step_s;
  if (both || (!the_case.fluid.relaxation_time && !the_case.given_step_s)) {
    problems.error(both ? "step_s" : "fluid.relaxation_time",
                   std::string("the case gives ") +
                       (both ? "both fluid.relaxation_time and step_s" : "neither fluid.relaxation_time nor step_s") +
                       " (one follows from the other). Give exactly one.");
    return;
  }
  const FluidCase& fluid = the_case.fluid;
  if (fluid.relaxation_time && (fluid.cell_size_m == 0.0 || fluid.kinematic_viscosity_m2_per_s == 0.0)) {
    problems.reject("fluid.relaxation_time",
                    "alone gives no step (it follows with the viscosity and the cell). Give "
                    "fluid.kinematic_viscosity_m2_per_s and fluid.cell_size_m, or step_s instead.");
    return;
  }
  if (!fluid.relaxation_time && !on_lattice(the_case)) return;
  const double tau = relaxation_time(the_case);
  const std::string found = "relaxation_time " + rounded_text(fluid.relaxation_time.value_or(tau));
  if (!(tau > 0.5)) {
    problems.error(
        time_key(the_case),
        found + " (it must exceed 1/2: viscosity is proportional to the excess). Use a value such as 0.6667.");
  } else if (!on_lattice(the_case)) {
    return;
  } else if (the_case.fluid.collision == CollisionKind::bgk && tau < 0.52) {
    problems.error(time_key(the_case),
                   found + " (bgk is unstable below about 0.52). Use collision: trt or a larger cell.");
  } else if (tau > 2.0 && has_walls(the_case.fluid)) {
    problems.warning(
        time_key(the_case),
        found +
            " (bounce-back walls shift noticeably above about 2, most with bgk). Use a smaller step or a larger cell.");
  }
}

void check_domain(const Case& the_case, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const BoundaryKind low = fluid.boundaries[2 * axis].kind;
    const BoundaryKind high = fluid.boundaries[2 * axis + 1].kind;
    if ((low == BoundaryKind::periodic) != (high == BoundaryKind::periodic)) {
      const std::size_t other = 2 * axis + (low == BoundaryKind::periodic ? 1 : 0);
      problems.reject(face_path(other), std::string("is ") + name_of(boundary_names, fluid.boundaries[other].kind) +
                                            " but the opposite face is periodic (what leaves there must come in here). "
                                            "Make both periodic or neither.");
    }
  }
  if (!on_lattice(the_case)) return;
  constexpr std::int64_t most_cells = std::int64_t{1} << 40;
  double cells = 1.0;
  for (const std::int64_t count : fluid.domain_cells) cells *= static_cast<double>(count);
  if (cells > static_cast<double>(most_cells)) {
    problems.reject("fluid.domain_cells",
                    "are " + rounded_text(cells) + " cells in all (no machine holds them). Use fewer or larger cells.");
    return;
  }
  check_open_faces(fluid, problems);
  check_initial_flow(fluid, problems);
}

void check_mixture(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  if (fluid.solver != FluidSolverChoice::lattice_boltzmann || assembly.bodies.empty()) return;
  for (std::size_t i = 0; i < assembly.bodies.size() && !fluid.body_force_N_per_m3.isZero(0.0); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    const Eigen::Vector3d gradient_N = volume_m3(body.shape) * fluid.body_force_N_per_m3;
    Eigen::Vector3d lacking_N = gradient_N;
    for (const auto& [actuator, signal] : assembly.drive)
      if (actuator.kind == ActuatorKind::world_force && signal.kind == SignalKind::constant &&
          static_cast<std::size_t>(actuator.body_A) == i)
        lacking_N -= signal.amplitude * actuator.direction;
    if (!moves_under_loads(body) || lacking_N.norm() < 0.02 * gradient_N.norm()) continue;
    problems.warn("fluid.body_force_N_per_m3",
                  "acts on the fluid alone (body '" + body.name + "' lacks " + rounded_text(lacking_N.norm()) +
                      " N of what a pressure gradient would exert: a neutral sphere of 0.6 of a slit's width moves 9 % "
                      "slower). Use pressure_Pa at the faces, or give bodies a world_force.");
    break;
  }
  const Eigen::Vector3d force_N = net_force_N(the_case, assembly);
  const double mass_kg = fluid.density_kg_per_m3 * fluid.length_m().prod();
  const double gain_lu = force_N.norm() / mass_kg * static_cast<double>(the_case.steps) * the_case.step_s *
                         the_case.step_s / fluid.cell_size_m;
  if (gain_lu < 1e-6) return;
  problems.warning("fluid.boundaries",
                   "a net force of " + rounded_text(force_N.norm()) +
                       " N acts on fluid and bodies (nothing holds them: they accelerate for ever, by " +
                       rounded_text(gain_lu) +
                       " cells per step until the end of the run). Balance it by fluid.body_force_N_per_m3, or add a "
                       "wall or a fixed body.");
}

}  // namespace copepod::coupler
