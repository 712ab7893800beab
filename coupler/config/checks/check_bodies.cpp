#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "contract/words.hpp"
#include "geometry/near_pairs.hpp"

namespace copepod::coupler {
namespace {

std::string known_names(const Assembly& assembly) {
  constexpr std::size_t most = 8;
  std::vector<std::string> names;
  for (const BodySpecification& body : assembly.bodies) names.push_back(body.name);
  const bool all_fit = names.size() <= most;
  if (!all_fit) names.resize(most);
  return listed(names) + (all_fit ? "" : ", …");
}

bool rests(const BodySpecification& body) {
  return body.motion == MotionKind::fixed ||
         (body.motion == MotionKind::prescribed && body.velocity_m_per_s.isZero(0.0) &&
          body.angular_velocity_rad_per_s.isZero(0.0));
}

/// Thin films, which cells do not resolve, are not known of all shapes.
std::string remedy(bool films_are_known) {
  return films_are_known ? ", or write lubrication: {cut_off_cells: auto}."
                         : ": lubrication is of spheres with capsules or ellipsoids.";
}

/// Judges the gap between a body and a face that is not periodic as the fluid service does
/// [docs/theory_fluid.md, (F7)].
void check_gap(double gap_m, const FluidCase& fluid, std::size_t face, const BodySpecification& body,
               const std::string& path, Problems& problems) {
  const std::string axis = axis_names[face / 2];
  constexpr double rounding = 1e-9;  // of a cell
  if (gap_m < -rounding * fluid.cell_size_m) {
    if (rests(body)) return;
    problems.error(path, "body '" + body.name + "' reaches " + length_text(-gap_m) + " beyond the " + axis +
                             " face (bodies that move must lie inside the domain). Move it, or enlarge domain_cells.");
  } else if (gap_m < fluid.cell_size_m && (fluid.film_thickness_m == 0.0 || !have_films(body.shape, body.shape))) {
    problems.warning(path, "body '" + body.name + "' is less than one cell from the " + axis +
                               " face (no fluid cell in between: its forces will be wrong). Move it away" +
                               remedy(have_films(body.shape, body.shape)));
  }
}

void check_resolution(const FluidCase& fluid, const BodySpecification& body, const std::string& path,
                      Problems& problems) {
  const double radius_cells = body.shape.radius_m / fluid.cell_size_m;
  const std::string found = "body '" + body.name + "' has a radius of " + rounded_text(radius_cells) + " cells (";
  if (radius_cells < 0.1) {
    problems.error(path, found + "no cell lies in it). Is one of radius_m, " + length_text(body.shape.radius_m) +
                             ", and fluid.cell_size_m, " + length_text(fluid.cell_size_m) +
                             ", a slip? Use at least four cells per radius.");
  } else if (radius_cells < 2.0) {
    problems.warning(path, found + "its shape is not resolved). Use smaller cells: four per radius are usual.");
  } else if (!is_round(body.shape)) {
    const double thickness_cells = thickness_m(body.shape) / fluid.cell_size_m;
    if (thickness_cells < 2.0)
      problems.warning(
          path,
          "body '" + body.name + "' is " + rounded_text(thickness_cells) +
              " cells thick where it is thin (such parts are not resolved). Use smaller cells, or thicker parts.");
  }
}

void check_in_domain(const FluidCase& fluid, const BodySpecification& body, const std::string& path, bool has_contacts,
                     Problems& problems) {
  const Eigen::Vector3d length = fluid.length_m();
  const Eigen::Vector3d half = half_extents_m(body);
  constexpr double most_lengths = 1000.0;  // from which a body may have come across periodic faces
  for (int axis = 0; axis < 3; ++axis) {
    const auto face = 2 * static_cast<std::size_t>(axis);
    if (length[axis] == 0.0) continue;
    if (fluid.boundaries[face].kind != BoundaryKind::periodic) {
      const Eigen::Vector3d up = Eigen::Vector3d::Unit(axis);
      check_gap(body.position_m[axis] - extent_m(body, -up), fluid, face, body, path, problems);
      check_gap(length[axis] - extent_m(body, up) - body.position_m[axis], fluid, face + 1, body, path, problems);
    } else if (std::abs(body.position_m[axis]) > most_lengths * length[axis]) {
      problems.error(path, "body '" + body.name + "' starts at " + axis_names[axis] + " = " +
                               length_text(body.position_m[axis]) + " (the domain is " + length_text(length[axis]) +
                               " long). Is its place in metres?");
    } else if (2 * half[axis] >= length[axis]) {
      problems.error(path, "body '" + body.name + "' is longer than the periodic domain along " + axis_names[axis] +
                               " (it would meet its own image). Use a smaller body or more cells.");
    } else if (has_contacts && 2.0 * bounding_radius_m(body.shape) > length[axis]) {
      problems.error(path, "body '" + body.name + "' is longer than the periodic domain along " + axis_names[axis] +
                               " (turned, it would be in contact with its own image). Use a larger domain.");
      return;
    }
  }
}

/// A run would end in its first step.
void check_bodies_in_obstacles(const FluidCase& fluid, const Assembly& assembly, Problems& problems) {
  if (fluid.obstacles.empty()) return;
  const std::size_t bodies = assembly.bodies.size(), all = bodies + fluid.obstacles.size();
  std::vector<Shape> shapes;
  Eigen::Matrix3Xd position_m(3, all);
  Eigen::Matrix4Xd orientation_wxyz(4, all);
  const auto add = [&](const auto& item) {
    const auto column = static_cast<Eigen::Index>(shapes.size());
    position_m.col(column) = item.position_m;
    orientation_wxyz.col(column) = item.orientation_wxyz;
    shapes.push_back(item.shape);
  };
  std::ranges::for_each(assembly.bodies, add);
  std::ranges::for_each(fluid.obstacles, add);
  const Overlaps overlaps(std::move(shapes), {fluid.periodic_length_m()});
  for (std::size_t i = bodies; i < all; ++i) {
    for (std::size_t body = 0; body < bodies; ++body) {
      const double depth_m =
          overlaps.depth_inside_m(static_cast<int>(body), static_cast<int>(i), position_m, orientation_wxyz);
      if (!(depth_m > 0.0)) continue;
      problems.error(assembly.body_paths[body],
                     "body '" + assembly.bodies[body].name + "' reaches " + length_text(depth_m) + " into obstacle '" +
                         fluid.obstacles[i - bodies].name + "' (solid bodies cannot). Move one of them.");
    }
  }
}

void check_overlaps(const FluidCase& fluid, const Assembly& assembly, Problems& problems) {
  const std::array<double, 3> periodic = fluid.periodic_length_m();
  const std::vector<BodyPair> jointed = jointed_pairs(assembly.joints);
  for (const auto& [a, b] : near_pairs(assembly.bodies, periodic, fluid.cell_size_m)) {
    if (std::ranges::binary_search(jointed, BodyPair{a, b})) continue;
    const BodySpecification& A = assembly.bodies[a];
    const BodySpecification& B = assembly.bodies[b];
    const double gap = surface_distance_m(A, B, periodic, fluid.cell_size_m);
    const std::string pair = "bodies '" + A.name + "' and '" + B.name + "'";
    if (gap < 0.0) {
      problems.error(assembly.body_paths[b],
                     pair + " overlap by " + length_text(-gap) + " (solid bodies cannot). Move them apart.");
    } else if (const bool films = have_films(A.shape, B.shape);
               gap < fluid.cell_size_m && (fluid.film_thickness_m == 0.0 || !films)) {
      problems.warning(assembly.body_paths[b], pair +
                                                   " are less than one cell apart (no fluid cell in between: a "
                                                   "spurious force appears). Move them apart, use smaller cells" +
                                                   remedy(films));
    }
  }
}

}  // namespace

void check_names(const Case& the_case, const Assembly& assembly, Problems& problems) {
  std::map<std::string, std::string> seen;
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    const std::string& name = assembly.bodies[i].name;
    const auto [first, inserted] = seen.emplace(name, assembly.body_paths[i]);
    if (inserted || problems.any_under(assembly.body_paths[i])) continue;
    problems.error(
        assembly.body_paths[i] + (i + the_case.bodies.size() < assembly.bodies.size() ? "" : ".name"),
        "two bodies are called '" + name + "' (springs, actuators and results need one each). Rename one of them.");
  }
  const auto require_body = [&](const std::string& name, const std::string& path) {
    if (name.empty() || seen.contains(name)) return;  // an empty one was reported when it was read
    if (problems.any_under("body.model")) return;     // its bodies are missing
    problems.reject(path, "names the body '" + name + "' (there is none). Known: " + known_names(assembly) + ".");
  };
  const auto require_bodies = [&](const auto& items, const std::string& section) {
    for (std::size_t i = 0; i < items.size(); ++i) {
      for (const std::string& name : items[i].bodies)
        require_body(name, section + "." + std::to_string(i) + (items[i].bodies.size() > 1 ? ".bodies" : ".body"));
    }
  };
  std::set<std::string> measured;
  for (const Swimmer& swimmer : the_case.swimmers) measured.insert(swimmer.name);
  for (std::size_t i = 0; i < the_case.groups.size(); ++i) {
    const std::string path = "groups." + std::to_string(i);
    const NamedGroup& group = the_case.groups[i];
    for (const std::string& name : group.bodies) require_body(name, path + ".bodies");
    if (measured.insert(group.name).second) continue;
    problems.reject(path + ".name", "is '" + group.name + "' (a swimmer or another group has this name). Rename it.");
  }
  require_bodies(the_case.springs, "springs");
  require_bodies(the_case.bends, "bends");
  require_bodies(the_case.actuators, "actuators");
  std::set<std::string> components{"fluid", "body", "coupler"};
  std::map<std::string, std::string> steered;
  for (std::size_t i = 0; i < the_case.controllers.size(); ++i) {
    const std::string path = "controllers." + std::to_string(i);
    const ControllerCase& controller = the_case.controllers[i];
    for (const std::string& name : controller.bodies) require_body(name, path + ".observes");
    for (const std::string& actuator : controller.actuators) {
      if (std::ranges::count(assembly.drive_paths, actuator) != 1)
        problems.reject(path + ".sets", "names " + actuator + " (which drives nothing, or two arms at once). Known: " +
                                            listed(assembly.drive_paths) + ".");
      else if (!steered.emplace(actuator, path).second)
        problems.reject(path + ".sets", "names " + actuator + " (so does " + steered[actuator] +
                                            ", and it has one value). Let one of them set it.");
    }
    if (!controller.name.empty() && !components.insert(controller.name).second)
      problems.reject(path + ".name", "is '" + controller.name + "' (another component has this name). Rename it.");
  }
  seen.emplace(NamedJoint::world, "");  // in joints only
  require_bodies(the_case.joints, "joints");
}

void check_bodies(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const auto& three_beads = the_case.swimmers[i].three_beads;
    if (!three_beads || (three_beads->rest_gap_m[0] > 0.0 && three_beads->rest_gap_m[1] > 0.0)) continue;
    const std::string path = path_of_swimmer(the_case, i) + ".rest_gap_m";
    problems.reject(path, "is not positive (the beads would touch at rest). Give the free distance between surfaces.");
    return;
  }
  for (std::size_t i = 0; i < assembly.bodies.size() && on_lattice(the_case); ++i) {
    check_in_domain(fluid, assembly.bodies[i], assembly.body_paths[i], the_case.contact.has_value(), problems);
    check_resolution(fluid, assembly.bodies[i], assembly.body_paths[i], problems);
  }
  check_overlaps(fluid, assembly, problems);
  check_bodies_in_obstacles(fluid, assembly, problems);
}

}  // namespace copepod::coupler
