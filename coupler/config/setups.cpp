#include "config/setups.hpp"

#include <algorithm>
#include <cmath>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "contract/errors.hpp"
#include "contract/features.hpp"
#include "contract/words.hpp"
#include "driving/prescribed_bodies.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/near_pairs.hpp"

namespace copepod::coupler {

namespace {

/// How far bodies can fall: along the domain, or from the highest to the lowest where there is none.
double height_of_fall_m(const Case& the_case, const Assembly& assembly) {
  const Eigen::Vector3d& gravity = the_case.body.gravity_m_per_s2;
  if (gravity.isZero(0.0)) return 0.0;
  const Eigen::Vector3d down = gravity.normalized();
  const double along_domain_m = down.cwiseAbs().dot(the_case.fluid.length_m());
  if (along_domain_m > 0.0) return along_domain_m;
  const auto depth_m = [&](const BodySpecification& body) { return down.dot(body.position_m); };
  const auto [highest, lowest] = std::ranges::minmax_element(assembly.bodies, {}, depth_m);
  return assembly.bodies.empty() ? 0.0 : depth_m(*lowest) - depth_m(*highest);
}

double weight_N(const BodySpecification& body, const Case& the_case) {
  return std::abs(body.mass_kg - displaced_kg(body, the_case.fluid)) * the_case.body.gravity_m_per_s2.norm();
}

double expected_speed_m_per_s(const BodySpecification& body, const Case& the_case, double height_m) {
  const FluidCase& fluid = the_case.fluid;
  const double weight = weight_N(body, the_case);
  double settling = std::sqrt(2.0 * weight / body.mass_kg * height_m);
  const double drag_kg_per_s = stokes_drag_kg_per_s(body.shape.radius_m, fluid);
  if (fluid.kind != FluidKind::vacuum && drag_kg_per_s > 0.0) settling = std::min(settling, weight / drag_kg_per_s);
  return std::max(body.velocity_m_per_s.norm(), settling);
}

double largest_drive_N(const Assembly& assembly) {
  double largest_N = 0.0;
  for (const DrivenActuator& driven : assembly.drive) {
    const ActuatorKind kind = driven.actuator.kind;
    if (kind != ActuatorKind::pair_force && kind != ActuatorKind::body_force && kind != ActuatorKind::world_force)
      continue;
    largest_N = std::max(largest_N, largest_magnitude(driven.signal));
  }
  return largest_N;
}

WallSpecification plane_of(const FluidCase& fluid, std::size_t face) {
  const auto axis = static_cast<Eigen::Index>(face / 2);
  const bool high = face % 2 == 1;
  WallSpecification plane;
  plane.normal = (high ? -1.0 : 1.0) * Eigen::Vector3d::Unit(axis);
  plane.point_m = (high ? fluid.length_m()[axis] : 0.0) * Eigen::Vector3d::Unit(axis);
  plane.removes_bodies = fluid.boundaries[face].removes_bodies;
  return plane;
}

/// The wall at a face, as far as bodies meet one there.
std::optional<WallSpecification> wall_at(const Case& the_case, std::size_t face) {
  const FluidCase& fluid = the_case.fluid;
  WallSpecification wall = plane_of(fluid, face);
  wall.friction = the_case.contact->wall_friction.value_or(the_case.contact->friction);
  if (fluid.kind == FluidKind::stokes)
    return fluid.no_slip_plane == static_cast<int>(face) ? std::optional(wall) : std::nullopt;
  if (fluid.length_m()[face / 2] == 0.0) return {};
  const Boundary& boundary = fluid.boundaries[face];
  switch (boundary.kind) {
    case BoundaryKind::no_slip:
      return wall;
    case BoundaryKind::free_slip:
      wall.friction = 0.0;
      return wall;
    case BoundaryKind::velocity:
      wall.velocity_m_per_s = boundary.velocity_m_per_s;
      return boundary.is_wall(face) ? std::optional(wall) : std::nullopt;
    case BoundaryKind::periodic:
    case BoundaryKind::pressure:
    case BoundaryKind::outflow:
      break;
  }
  return {};
}

/// Faces that bodies meet: with friction where the fluid sticks to them, without where it slips; not where the fluid
/// flows through.
std::vector<WallSpecification> contact_walls(const Case& the_case) {
  std::vector<WallSpecification> walls;
  if (!the_case.contact) return walls;
  for (std::size_t face = 0; face < 6; ++face)
    if (const auto wall = wall_at(the_case, face)) walls.push_back(*wall);
  return walls;
}

/// Overlap that contacts should not exceed, in radii of the smallest body.
constexpr double allowed_overlap = 0.01;

/// Stiffness as given, or the larger of two: what keeps overlaps below `allowed_overlap`, and the stiffest that needs
/// no substeps [N/m].
double contact_stiffness(const Case& the_case, const Assembly& assembly) {
  if (the_case.contact->stiffness_N_per_m) return *the_case.contact->stiffness_N_per_m;
  const ExpectedContacts expected = expected_contacts(the_case, assembly);
  if (expected.inverse_mass_per_kg == 0.0) return 1.0;  // nothing moves: any will do
  const double overlap_m = allowed_overlap * expected.smallest_radius_m;
  const double needed = std::max(expected.force_N / overlap_m, expected.impact_N_m / (overlap_m * overlap_m));
  return std::max(needed, stiffness_of_contact(substeps_per_contact * the_case.step_s, expected.inverse_mass_per_kg));
}

/// What body components receive; of a case without contacts: nothing.
ContactSpecification contact_specification(const Case& the_case, const Assembly& assembly) {
  if (!the_case.contact || assembly.bodies.empty()) return {};
  return {contact_stiffness(the_case, assembly), the_case.contact->restitution, the_case.contact->friction};
}

/// Where a lattice is, a body that leaves it ends the run.
void warn_of_open_faces(const Case& the_case, Problems& problems) {
  std::string open;
  for (std::size_t face = 0; face < 6 && !on_lattice(the_case); ++face) {
    if (the_case.fluid.length_m()[face / 2] == 0.0 || wall_at(the_case, face)) continue;
    if (the_case.fluid.boundaries[face].kind == BoundaryKind::periodic) continue;
    open.append(open.empty() ? "" : ", ").append(face_path(face));
  }
  if (open.empty()) return;
  problems.warn("contact", "leaves out " + open + " (there is no wall for bodies in solver: " +
                               name_of(solver_names, the_case.fluid.solver) + "). They pass through.");
}

/// Where a lattice is, check_bodies has looked at its faces.
void check_walls_at_start(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (on_lattice(the_case)) return;
  for (const WallSpecification& wall : contact_walls(the_case)) {
    for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
      const BodySpecification& body = assembly.bodies[i];
      const double gap_m =
          wall.normal.dot(body.position_m - wall.point_m) - wall.normal.cwiseAbs().dot(half_extents_m(body));
      if (gap_m >= 0.0 || !moves_under_loads(body)) continue;
      problems.error(assembly.body_paths[i],
                     "body '" + body.name + "' reaches " + length_text(-gap_m) +
                         " into a wall (a contact would push it out at once). Move it, or enlarge domain_cells.");
    }
  }
}

}  // namespace

FluidSetup make_fluid_setup(const Case& the_case, const Assembly& assembly, const std::string& field_directory) {
  FluidSetup setup = static_cast<const FluidSetup&>(the_case.fluid);
  setup.step_s = the_case.step_s;
  for (const BodySpecification& body : assembly.bodies) setup.bodies.push_back(body.shape);
  setup.jointed = jointed_pairs(assembly.joints);
  constexpr double of_a_cell = 0.25;  // contacts are soft
  if (the_case.contact) setup.wall_overlap_m = of_a_cell * setup.cell_size_m;
  setup.fields = the_case.output.fields;
  setup.fields.directory = field_directory;
  if (!computes_no_cells(the_case.fluid.solver)) setup.flow = the_case.output.flow;
  return setup;
}

BodySetup make_body_setup(const Case& the_case, const Assembly& assembly) {
  const FluidCase& fluid = the_case.fluid;
  BodySetup setup = static_cast<const BodySetup&>(the_case.body);
  setup.threads = the_case.services.body_threads;
  setup.step_s = the_case.step_s;
  setup.fluid_density_kg_per_m3 = fluid.kind == FluidKind::vacuum ? 0.0 : fluid.density_kg_per_m3;
  setup.periodic_length_m = fluid.periodic_length_m();
  setup.bodies = assembly.bodies;
  setup.springs = assembly.springs;
  setup.bends = assembly.bends;
  setup.joints = assembly.joints;
  for (const DrivenActuator& driven : assembly.drive) setup.actuators.push_back(driven.actuator);
  setup.contact = contact_specification(the_case, assembly);
  setup.walls = contact_walls(the_case);
  for (std::size_t face = 0; face < 6; ++face) {
    if (!fluid.boundaries[face].removes_bodies) continue;
    setup.walls.push_back(plane_of(fluid, face));
    // A body that covers cells beside the face has links on one side only, and takes up mass.
    setup.walls.back().point_m += fluid.cell_size_m * setup.walls.back().normal;
  }
  take_out(assembly.prescribed, setup);
  return setup;
}

ControllerSetup make_controller_setup(const Case& the_case, const Assembly& assembly, std::size_t number) {
  ControllerSetup setup = the_case.controllers[number];
  setup.step_s = the_case.step_s;
  if (setup.bodies.empty())
    for (const BodySpecification& body : assembly.bodies) setup.bodies.push_back(body.name);
  setup.flow = make_fluid_setup(the_case, assembly, "").flow.names();
  return setup;
}

double unit_of_actuator(const Assembly& assembly, std::size_t number) {
  const int spring = number < assembly.drive.size() ? assembly.drive_springs[number] : -1;
  return spring < 0 ? 1.0 : assembly.springs[spring].stiffness_N_per_m;
}

AttachedController attached(std::unique_ptr<Controller> controller, const ControllerSetup& setup,
                            const Assembly& assembly) {
  AttachedController result{std::move(controller), setup.every_steps, {}, {}, std::ssize(setup.flow)};
  for (const std::string& name : setup.bodies)
    result.bodies.push_back(std::ranges::find(assembly.bodies, name, &BodySpecification::name) -
                            assembly.bodies.begin());
  for (const std::string& path : setup.actuators) {
    const auto number =
        static_cast<std::size_t>(std::ranges::find(assembly.drive_paths, path) - assembly.drive_paths.begin());
    const bool moves = number >= assembly.drive.size() ||  // a prescribed body
                       assembly.drive[number].actuator.kind == ActuatorKind::joint_motion;
    result.actuators.push_back({number, unit_of_actuator(assembly, number), moves});
  }
  return result;
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

double ExpectedContacts::overlap_m(double stiffness_N_per_m) const {
  return std::max(force_N / stiffness_N_per_m, std::sqrt(impact_N_m / stiffness_N_per_m));
}

ExpectedContacts expected_contacts(const Case& the_case, const Assembly& assembly) {
  ExpectedContacts expected;
  const double height_m = height_of_fall_m(the_case, assembly);
  double heaviest_N = 0.0;
  double moving = 0.0;
  for (const BodySpecification& body : assembly.bodies) {
    const double radius_m = body.shape.radius_m;
    const double smallest_m = expected.smallest_radius_m;
    expected.smallest_radius_m = smallest_m == 0.0 ? radius_m : std::min(smallest_m, radius_m);
    const double speed_m_per_s =
        moves_under_loads(body) ? expected_speed_m_per_s(body, the_case, height_m) : body.velocity_m_per_s.norm();
    if (moves_under_loads(body)) {
      heaviest_N = std::max(heaviest_N, weight_N(body, the_case));
      moving += 1.0;
    }
    expected.impact_N_m = std::max(expected.impact_N_m, 2.0 * body.mass_kg * speed_m_per_s * speed_m_per_s);
  }
  const double layers = std::max(1.0, std::min(moving, height_m / (2.0 * expected.smallest_radius_m)));
  expected.force_N = std::max(heaviest_N * layers, largest_drive_N(assembly));
  expected.inverse_mass_per_kg = largest_inverse_mass_per_kg(assembly.bodies);
  return expected;
}

void check_contact(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (!the_case.contact || assembly.bodies.empty()) return;
  const std::string path = "contact.stiffness_N_per_m";
  const ExpectedContacts expected = expected_contacts(the_case, assembly);
  const double stiffness = contact_stiffness(the_case, assembly);
  BodySetup setup;
  setup.step_s = the_case.step_s;
  setup.bodies = assembly.bodies;
  setup.contact = contact_specification(the_case, assembly);
  constexpr double most_substeps = 1e5;
  constexpr double many_substeps = 1000;
  const double substeps = contact_substeps(setup);
  const std::string found = "the contacts need " + rounded_text(substeps) + " substeps in every step (";
  if (substeps > many_substeps) {
    const std::string why = "the shortest lasts " +
                            rounded_text(shortest_contact_s(stiffness, expected.inverse_mass_per_kg)) +
                            " s). Use a shorter step, or a smaller contact.stiffness_N_per_m.";
    if (substeps > most_substeps)
      problems.error(path, found + why);
    else
      problems.warning(path, found + why);
  }
  const double overlap_m = expected.overlap_m(stiffness);
  if (overlap_m > 5.0 * allowed_overlap * expected.smallest_radius_m) {
    problems.warning(
        path,
        "bodies may overlap by " + length_text(overlap_m) +
            ", more than 5 % of a radius (the contacts are soft). Use a larger contact.stiffness_N_per_m, or auto.");
  }
  if (!assembly.prescribed.empty()) {
    problems.warn("contact",
                  "leaves out bodies whose motion is a function of time (the coupler moves them, and a run in which "
                  "they meet another body ends). Prescribe constant velocities with motion: prescribed.");
  }
  for (std::size_t face = 0; face < 6; ++face) {
    const auto wall = wall_at(the_case, face);
    if (the_case.fluid.boundaries[face].signal && wall && wall->friction > 0.0)
      problems.reject(face_path(face) + ".signal",
                      "varies the velocity of a wall with friction (contacts take it as constant). Use "
                      "contact.wall_friction: 0, or a constant velocity.");
  }
  warn_of_open_faces(the_case, problems);
  check_walls_at_start(the_case, assembly, problems);
}

}  // namespace copepod::coupler
