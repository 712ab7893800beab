#include <algorithm>
#include <cmath>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

constexpr double plane_tolerance = 1e-9;

/// A mirror plane through the middle of the domain.
struct Plane {
  const FluidCase& fluid;
  int axis;  ///< normal to it
  std::string name = axis_names[axis];
  std::string text = "symmetry plane " + name;
  double middle_m = 0.5 * fluid.length_m()[axis];

  [[nodiscard]] double tolerance_m() const { return plane_tolerance * fluid.cell_size_m; }

  /// Whether the mirror image of a face is the condition given there.
  [[nodiscard]] bool mirrors(std::size_t face) const {
    const Boundary& one = fluid.boundaries[face];
    const Boundary& other = fluid.boundaries[static_cast<int>(face / 2) == axis ? face ^ 1U : face];
    Eigen::Vector3d reflected = other.velocity_m_per_s;
    reflected[axis] *= -1.0;
    return one.kind == other.kind && one.pressure_Pa == other.pressure_Pa && one.velocity_m_per_s == reflected &&
           one.parabolic == other.parabolic && one.signal == other.signal && one.profile == other.profile &&
           one.removes_bodies == other.removes_bodies;
  }

  /// A body either lies on the plane or stays in the half that is computed: it then has a mirror image of its own.
  [[nodiscard]] bool holds(const BodySpecification& body) const {
    return std::abs(body.position_m[axis] - middle_m) <= tolerance_m();
  }

  /// Whether a direction lies neither in the plane nor across it.
  [[nodiscard]] bool is_oblique_to(const Eigen::Vector3d& direction) const {
    const double along = std::abs(direction[axis]);
    return along > plane_tolerance && along < 1.0 - plane_tolerance;
  }
};

void check_symmetric_faces(const Plane& plane, Problems& problems) {
  const auto low = 2 * static_cast<std::size_t>(plane.axis);
  if (plane.fluid.domain_cells[plane.axis] % 2 != 0) {
    problems.reject("fluid.domain_cells", "has " + std::to_string(plane.fluid.domain_cells[plane.axis]) +
                                              " cells along " + plane.name + " (" + plane.text +
                                              " must lie between two cells). Use an even number.");
  }
  if (plane.fluid.boundaries[low].kind == BoundaryKind::periodic)
    return problems.reject(
        face_path(low),
        "is periodic across " + plane.text +
            " (both together mirror the flow at the outer face too). Use free_slip, which is the same.");
  for (std::size_t face = 0; face < 6; ++face) {
    if (plane.mirrors(face)) continue;
    return problems.reject(face_path(face),
                           "is not its own mirror image about " + plane.text +
                               " (the flow could not be symmetric). Remove the plane or make the faces alike.");
  }
}

/// Reports vectors that have a component which the mirror would turn round.
void check_symmetric_vector(const Eigen::Vector3d& vector, const std::string& path, const Plane& plane,
                            Problems& problems) {
  if (vector[plane.axis] == 0.0) return;
  problems.reject(path, "has a component along " + plane.name + " (" + plane.text +
                            " allows none). Set it to 0 or remove the plane.");
}

/// Without cells bodies on a plane are computed whole, which is the same, but no mirror images.
void check_images_not_computed(const Assembly& assembly, const Plane& plane, Problems& problems) {
  if (plane.middle_m == 0.0)
    return problems.error(
        "fluid.symmetry_planes",
        plane.text +
            " has no position (it passes through the middle of the domain). Give fluid.domain_cells and "
            "fluid.cell_size_m, or remove the plane.");
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    if (plane.holds(assembly.bodies[i])) continue;
    problems.error(assembly.body_paths[i], "body '" + assembly.bodies[i].name + "' lies beside " + plane.text +
                                               " (solver: " + name_of(solver_names, plane.fluid.solver) +
                                               " computes no mirror images). Give its image as a body too and "
                                               "remove the plane, or use solver: lattice_boltzmann.");
  }
}

void check_symmetric_body(const BodySpecification& body, const std::string& path, const Plane& plane,
                          Problems& problems) {
  const std::string found = "body '" + body.name + "' ";
  if (!plane.holds(body)) {
    const double off_m = body.position_m[plane.axis] - plane.middle_m;
    if (off_m + half_extents_m(body)[plane.axis] > plane.tolerance_m())
      problems.error(path, found + "is " + length_text(std::abs(off_m)) + " off " + plane.text +
                               " and reaches beyond it (a body lies on the plane, or all of it in the lower half "
                               "and its mirror image in the upper). Move it, or remove the plane.");
    return;
  }
  if (body.shape.kind == ShapeKind::mesh || body.shape.kind == ShapeKind::compound) {
    problems.error(path, found + "has shape " + word_of(body.shape) + " on " + plane.text +
                             " (whether it is its own mirror image is not known). Put all of it into the lower "
                             "half, or remove the plane.");
  }
  const Eigen::Matrix3d axes = rotation_matrix(body.orientation_wxyz);
  bool tilted = has_orientation(body.shape) && plane.is_oblique_to(body_axis(body));
  if (!is_round(body.shape) && body.shape.kind != ShapeKind::cylinder)
    for (int own = 0; own < 2; ++own) tilted = tilted || plane.is_oblique_to(axes.col(own));
  if (tilted) {
    problems.error(path,
                   found + "is tilted against " + plane.text +
                       " (it is not its own mirror image). Turn it into or across the plane, or remove the plane.");
  }
  if (body.motion == MotionKind::axis && plane.is_oblique_to(body.axis)) {
    problems.error(path, found + "may move along an axis oblique to " + plane.text +
                             " (forces within the plane would push it off). Turn the axis into or across the "
                             "plane, or remove the plane.");
  }
  Eigen::Vector3d forbidden_spin = body.angular_velocity_rad_per_s;
  forbidden_spin[plane.axis] = 0.0;
  if (body.velocity_m_per_s[plane.axis] != 0.0 || !forbidden_spin.isZero(0.0)) {
    problems.error(path,
                   found + "moves across " + plane.text +
                       " (its mirror image moves the other way). Give it a symmetric motion, or remove the plane.");
  }
}

/// What ties a body on the plane to one beside it would tie it to the mirror image too, and what pulls at a
/// point off the plane would pull at that point's image.
/// @param joint  a SpringSpecification, a JointSpecification, or an ActuatorSpecification of a pair
void check_symmetric_joint(const auto& joint, const std::string& what, const std::string& path,
                           const Assembly& assembly, const Plane& plane, Problems& problems) {
  if (joint.body_A < 0 || joint.body_B < 0) return;
  const BodySpecification& A = assembly.bodies[joint.body_A];
  const BodySpecification& B = assembly.bodies[joint.body_B];
  if (plane.holds(A) != plane.holds(B))
    return problems.error(path, what + " ties '" + A.name + "' to '" + B.name + "', only one of which lies on " +
                                    plane.text + " (its mirror image is not computed). Remove the plane.");
  if (!plane.holds(A)) return;
  const double off_A_m = std::abs(in_world(A, joint.anchor_A_m)[plane.axis]);
  const double off_B_m = std::abs(in_world(B, joint.anchor_B_m)[plane.axis]);
  if (std::max(off_A_m, off_B_m) <= plane.tolerance_m()) return;
  problems.error(path, what + " is anchored to '" + (off_A_m >= off_B_m ? A : B).name + "' " +
                           length_text(std::max(off_A_m, off_B_m)) + " off " + plane.text +
                           " (it would turn the body or pull it off the plane). Anchor it on the plane, or remove "
                           "the plane.");
}

/// The motion that a joint leaves must keep bodies on the plane.
void check_symmetric_axis(const JointSpecification& joint, const std::string& path, const Assembly& assembly,
                          const Plane& plane, Problems& problems) {
  if (!has_axis(joint.kind) || joint.body_A < 0 || !plane.holds(assembly.bodies[joint.body_A])) return;
  const double across = std::abs(in_world(assembly.bodies[joint.body_A], joint.axis)[plane.axis]);
  const bool turns = joint.kind == JointKind::hinge;
  if ((turns ? 1.0 - across : across) <= plane_tolerance) return;
  problems.reject(path + ".axis", (turns ? "is not along " : "is not across ") + plane.name + " (" + plane.text +
                                      " allows no other motion). Change the axis, or remove the plane.");
}

/// A bend between a body on the plane and two beside it on one side would have a mirror image of its own.
void check_symmetric_bend(const BendSpecification& bend, const std::string& path, const Assembly& assembly,
                          const Plane& plane, Problems& problems) {
  if (std::min({bend.body_A, bend.body_B, bend.body_C}) < 0) return;
  const auto on_plane = [&](int body) { return plane.holds(assembly.bodies[body]); };
  if (on_plane(bend.body_A) == on_plane(bend.body_B) && on_plane(bend.body_B) == on_plane(bend.body_C)) return;
  problems.reject(
      path, "is between bodies on and off " + plane.text + " (its mirror image is not computed). Remove the plane.");
}

/// A force must lie in the plane, a torque across it.
void check_symmetric_actuator(const ActuatorSpecification& actuator, const std::string& path, const Assembly& assembly,
                              const Plane& plane, Problems& problems) {
  if (actuator.kind == ActuatorKind::pair_force)
    return check_symmetric_joint(actuator, "a pair force", path, assembly, plane, problems);
  if (actuator.body_A < 0 || actuator.kind == ActuatorKind::control) return;
  const BodySpecification& body = assembly.bodies[actuator.body_A];
  if (!plane.holds(body)) return;
  const bool turns = actuator.kind == ActuatorKind::body_force || actuator.kind == ActuatorKind::body_torque;
  const bool torque = actuator.kind == ActuatorKind::body_torque || actuator.kind == ActuatorKind::world_torque;
  const Eigen::Vector3d direction = turns ? in_world(body, actuator.direction) : actuator.direction;
  const double across = std::abs(direction[plane.axis]);
  if ((torque ? 1.0 - across : across) <= plane_tolerance) return;
  problems.reject(path + ".direction",  // arms have pair forces only
                  (torque ? "is a torque not along " : "has a component along ") + plane.name + " (" + plane.text +
                      " allows none). Change its direction, or remove the plane.");
}

}  // namespace

void check_symmetry(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  for (int axis = 0; axis < 3; ++axis) {
    if (!fluid.symmetry_planes[axis] || fluid.solver == FluidSolverChoice::external) continue;
    const Plane plane{fluid, axis};
    if (on_lattice(the_case)) {
      check_symmetric_faces(plane, problems);
      check_symmetric_vector(fluid.body_force_N_per_m3, "fluid.body_force_N_per_m3", plane, problems);
      check_symmetric_vector(fluid.initial_flow.velocity_m_per_s, "fluid.initial_flow.velocity_m_per_s", plane,
                             problems);
    } else {
      check_images_not_computed(assembly, plane, problems);
    }
    check_symmetric_vector(the_case.body.gravity_m_per_s2, "gravity_m_per_s2", plane, problems);
    for (std::size_t i = 0; i < assembly.bodies.size(); ++i)
      check_symmetric_body(assembly.bodies[i], assembly.body_paths[i], plane, problems);
    for (std::size_t i = 0; i < assembly.springs.size(); ++i)
      check_symmetric_joint(assembly.springs[i], "a spring", assembly.spring_paths[i], assembly, plane, problems);
    for (std::size_t i = 0; i < assembly.joints.size(); ++i) {
      const std::string path = "joints." + std::to_string(i);
      JointSpecification joint = assembly.joints[i];
      check_symmetric_axis(joint, path, assembly, plane, problems);
      if (joint.body_B < 0) {  // the world has no mirror image: what the body's end must do is left
        joint.body_B = joint.body_A;
        joint.anchor_B_m = joint.anchor_A_m;
      }
      check_symmetric_joint(joint, "a joint", path, assembly, plane, problems);
    }
    for (std::size_t i = 0; i < assembly.bends.size(); ++i)
      check_symmetric_bend(assembly.bends[i], assembly.bend_paths[i], assembly, plane, problems);
    for (std::size_t i = 0; i < assembly.drive.size(); ++i) {
      if (assembly.drive_springs[i] >= 0) continue;  // a rest length acts where its spring does
      check_symmetric_actuator(assembly.drive[i].actuator, assembly.drive_paths[i], assembly, plane, problems);
    }
  }
}

}  // namespace copepod::coupler
