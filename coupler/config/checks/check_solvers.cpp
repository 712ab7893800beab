#include <cmath>
#include <limits>
#include <string>

#include <spdlog/fmt/fmt.h>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

void check_command(bool external, const std::vector<std::string>& command, const std::string& parameters,
                   const std::string& role, Problems& problems) {
  if (command.empty() && !parameters.empty())
    problems.reject("services." + role + ".parameters",
                    "has no effect (our own solvers read keys of their sections). Remove it, or name a component.");
  if (!external || !command.empty() || problems.any_under(role + ".solver")) return;
  problems.reject(
      role + ".solver",
      "is external (no component to start is named). Write solver: {command: …}, or give --" + role + " CMD.");
}

/// Height of the plane above the origin along its axis [m].
double plane_height_m(const FluidCase& fluid) {
  return fluid.no_slip_plane % 2 == 0 ? 0.0 : fluid.length_m()[fluid.no_slip_plane / 2];
}

void check_plane(const FluidCase& fluid, const Assembly& assembly, Problems& problems) {
  const std::string plane = std::string("no_slip_plane ") + name_of(plane_names, fluid.no_slip_plane);
  const bool high = fluid.no_slip_plane % 2 == 1;
  if (high && plane_height_m(fluid) == 0.0)
    return problems.error("fluid.no_slip_plane",
                          plane +
                              " has no position (the high faces are at the end of the domain). Give "
                              "fluid.domain_cells and fluid.cell_size_m, or use a low face.");
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    const double above_m = body.position_m[fluid.no_slip_plane / 2] - plane_height_m(fluid);
    const double gap_m = (high ? -above_m : above_m) - body.shape.radius_m;
    if (gap_m > 0.0) continue;
    problems.error(assembly.body_paths[i], "body '" + body.name + "' reaches " + length_text(-gap_m) + " beyond " +
                                               plane + " (the fluid ends there). Move it away from the plane.");
  }
}

/// The least distance of a body from another or from the plane, in radii of the smaller.
struct NearestSurfaces {
  double gap_radii = std::numeric_limits<double>::infinity();
  std::size_t body = 0;
  std::string other;
  bool plane = false;
};

NearestSurfaces nearest_surfaces(const FluidCase& fluid, const std::vector<BodySpecification>& bodies) {
  NearestSurfaces nearest;
  const auto consider = [&](double gap_m, double radius_m, std::size_t body, const std::string& other, bool plane) {
    if (gap_m / radius_m < nearest.gap_radii) nearest = {gap_m / radius_m, body, other, plane};
  };
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const double radius_m = bodies[i].shape.radius_m;
    if (fluid.no_slip_plane >= 0) {
      const double height_m = std::abs(bodies[i].position_m[fluid.no_slip_plane / 2] - plane_height_m(fluid));
      consider(height_m - radius_m, radius_m, i, "the no-slip plane", true);
    }
    for (std::size_t j = 0; j < i; ++j) {
      const double other_m = bodies[j].shape.radius_m;
      const double distance_m = (bodies[i].position_m - bodies[j].position_m).norm();
      consider(distance_m - radius_m - other_m, std::min(radius_m, other_m), i, "'" + bodies[j].name + "'", false);
    }
  }
  return nearest;
}

/// The mobility has no lubrication. That of a sphere towards a plane is 5, 22, 67, 215 % above Brenner's (1961) at gaps
/// of 1, 1/2, 1/4, 1/10 of its radius, that of two towards each other 10, 29, 70, 192 %; here within a third of that.
/// The links of a chain may be nearer than a sphere and a plane: they keep their distances.
void warn_of_near_surfaces(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const NearestSurfaces nearest = nearest_surfaces(the_case.fluid, assembly.bodies);
  if (nearest.gap_radii <= 0.0 || nearest.gap_radii >= (nearest.plane ? 1.0 : 0.3)) return;  // overlaps are errors
  const double percent =
      nearest.plane ? 22.0 * std::pow(0.5 / nearest.gap_radii, 1.5) : 29.0 * std::pow(0.5 / nearest.gap_radii, 1.25);
  problems.warning(
      assembly.body_paths[nearest.body],
      fmt::format("body '{}' starts {:.2g} radii from {} (solver: stokes has no lubrication: the mobility towards it "
                  "is about {:.0f} % too large there). Use larger gaps, or solver: lattice_boltzmann.",
                  assembly.bodies[nearest.body].name, nearest.gap_radii, nearest.other, percent));
}

/// What drives or repeats a flow is not known to Stokes flow: fluid at rest but for the bodies, and one wall
/// at most.
void warn_of_flows_left_out(const FluidCase& fluid, Problems& problems) {
  const std::string why = " (solver: stokes computes only the flow due to the bodies). It is ignored.";
  if (!fluid.body_force_N_per_m3.isZero(0.0)) problems.warn("fluid.body_force_N_per_m3", "drives a flow" + why);
  if (fluid.initial_flow.kind != InitialFlowKind::rest) problems.warn("fluid.initial_flow", "is a flow" + why);
  for (std::size_t face = 0; face < 6; ++face) {
    const BoundaryKind kind = fluid.boundaries[face].kind;
    if (kind == BoundaryKind::no_slip || kind == BoundaryKind::periodic || kind == BoundaryKind::free_slip) continue;
    problems.warn(face_path(face), "drives a flow" + why);
  }
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (fluid.boundaries[2 * axis].kind != BoundaryKind::periodic) continue;
    const std::string path = std::string("fluid.boundaries.") + axis_names[axis];
    problems.warn(path,
                  "is periodic (solver: stokes computes no flow around images of the bodies). They are left out.");
  }
}

/// Keys of a case written for the lattice that a solver without cells ignores.
void warn_of_what_is_left_out(const Case& the_case, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  const std::string solver = std::string("solver: ") + name_of(solver_names, fluid.solver);
  if (the_case.output.fields.every_steps > 0 || the_case.output.fields.mean_stop > 0) {
    problems.warn("output.fields", "asks for fields (" + solver + " computes none). They are left out.");
  }
  if (the_case.output.flow.every_steps > 0)
    problems.warn("output.flow", "asks for samples of the flow (" + solver + " computes none). They are left out.");
  if (fluid.solver != FluidSolverChoice::stokes) return;
  warn_of_flows_left_out(fluid, problems);
  if (fluid.domain_cells[0] > 0 && fluid.no_slip_plane < 0) {
    problems.warning("fluid.solver", "the fluid is taken as unbounded (" + solver +
                                         " ignores the domain's walls). Give fluid.no_slip_plane for one.");
  }
}

/// The part of a domain beyond a symmetry plane is the image of that before it.
bool crosses_plane(const ObstacleSpecification& obstacle, const FluidCase& fluid) {
  BodySpecification body;
  body.shape = obstacle.shape;
  body.orientation_wxyz = obstacle.orientation_wxyz;
  for (int axis = 0; axis < 3; ++axis)
    if (fluid.symmetry_planes[axis] &&
        obstacle.position_m[axis] + extent_m(body, Eigen::Vector3d::Unit(axis)) > 0.5 * fluid.length_m()[axis])
      return true;
  return false;
}

void check_obstacles(const Case& the_case, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  for (std::size_t i = 0; i < fluid.obstacles.size(); ++i) {
    const std::string path = "obstacles." + std::to_string(i);
    const std::string found = "obstacle '" + fluid.obstacles[i].name + "' ";
    if (computes_no_cells(fluid.solver))
      problems.error(path, found + "has no effect (solver: " + name_of(solver_names, fluid.solver) +
                               " has no cells). Use solver: lattice_boltzmann, or remove it.");
    else if (crosses_plane(fluid.obstacles[i], fluid))
      problems.error(path, found +
                               "reaches beyond a symmetry plane (what is there is the image of what is before it). "
                               "Keep it in the lower half, or compute the whole domain.");
    else if (the_case.contact)
      problems.warning(path, found +
                                 "pushes no body back (contact is between bodies and with walls). A body that meets it "
                                 "ends the run; write a body with motion: fixed for what they touch.");
  }
}

/// Shapes that a solver of ours cannot handle.
void check_shapes(const Case& the_case, const Assembly& assembly, Problems& problems) {
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const BodySpecification& body = assembly.bodies[i];
    if (is_round(body.shape)) continue;
    const std::string found = "body '" + body.name + "' has shape " + word_of(body.shape) + " (";
    if (the_case.fluid.solver == FluidSolverChoice::stokes)
      problems.error(assembly.body_paths[i],
                     found + "solver: stokes has spheres only). Use spheres, or solver: lattice_boltzmann.");
    if (the_case.contact && the_case.body.solver == BodySolverChoice::own)
      problems.error(assembly.body_paths[i], found +
                                                 "the body solver resolves contacts of spheres and capsules only). Use "
                                                 "body: {solver: bullet}, or remove contact.");
  }
}

}  // namespace

void check_solvers(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  const ServicesCase& services = the_case.services;
  check_command(fluid.solver == FluidSolverChoice::external, services.fluid_command, services.fluid_parameters, "fluid",
                problems);
  check_command(the_case.body.solver == BodySolverChoice::external, services.body_command, services.body_parameters,
                "body", problems);
  check_shapes(the_case, assembly, problems);
  check_obstacles(the_case, problems);
  if (computes_no_cells(fluid.solver)) warn_of_what_is_left_out(the_case, problems);
  if (fluid.solver != FluidSolverChoice::stokes) return;
  if (fluid.no_slip_plane >= 0) check_plane(fluid, assembly, problems);
  warn_of_near_surfaces(the_case, assembly, problems);
}

}  // namespace copepod::coupler
