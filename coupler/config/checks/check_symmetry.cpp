#include <algorithm>
#include <cmath>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "config/sections/case.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {
namespace {

/// Whether the mirror image of face `face` about the plane normal to `axis` is the condition given there.
bool mirrored(const FluidCase& fluid, std::size_t face, std::size_t axis) {
  const std::size_t image = face / 2 == axis ? face ^ 1U : face;
  const Boundary& one = fluid.boundaries[face];
  const Boundary& other = fluid.boundaries[image];
  Eigen::Vector3d reflected = other.velocity_m_per_s;
  reflected[static_cast<Eigen::Index>(axis)] *= -1.0;
  return one.kind == other.kind && one.pressure_Pa == other.pressure_Pa && one.velocity_m_per_s == reflected &&
         one.parabolic == other.parabolic && one.signal == other.signal;
}

constexpr double plane_tolerance = 1e-9;

/// Where symmetry plane `axis` is.
double middle_m(const FluidCase& fluid, std::size_t axis) {
  return 0.5 * static_cast<double>(fluid.domain_cells[axis]) * fluid.cell_size_m;
}

void check_symmetric_faces(const FluidCase& fluid, std::size_t axis, Problems& problems) {
  const std::string plane = std::string("symmetry plane ") + axis_names[axis];
  if (fluid.domain_cells[axis] % 2 != 0) {
    problems.reject("fluid.domain_cells", "has " + std::to_string(fluid.domain_cells[axis]) + " cells along " +
                                              axis_names[axis] + " (" + plane +
                                              " must lie between two cells). Use an even number.");
  }
  if (fluid.boundaries[2 * axis].kind == BoundaryKind::periodic) {
    problems.reject(face_path(2 * axis),
                    "is periodic across " + plane +
                        " (both together mirror the flow at the outer face too). Use free_slip, which is the same.");
    return;
  }
  for (std::size_t face = 0; face < 6; ++face) {
    if (mirrored(fluid, face, axis)) continue;
    problems.reject(face_path(face),
                    "is not its own mirror image about " + plane +
                        " (the flow could not be symmetric). Remove the plane or make the faces alike.");
    return;
  }
}

/// Reports vectors that have a component which the mirror would turn round.
void check_symmetric_vector(const Eigen::Vector3d& vector, std::size_t axis, const std::string& path,
                            Problems& problems) {
  if (vector[static_cast<Eigen::Index>(axis)] == 0.0) return;
  problems.reject(path, std::string("has a component along ") + axis_names[axis] + " (symmetry plane " +
                            axis_names[axis] + " allows none). Set it to 0 or remove the plane.");
}

/// A body either lies on the plane or stays in the half that is computed: it then has a mirror image of
/// its own.
bool lies_on(const BodySpecification& body, const FluidCase& fluid, std::size_t axis) {
  return std::abs(body.position_m[static_cast<Eigen::Index>(axis)] - middle_m(fluid, axis)) <=
         plane_tolerance * fluid.cell_size_m;
}

/// Whether a direction lies neither in the plane normal to `axis` nor across it.
bool oblique(const Eigen::Vector3d& direction, std::size_t axis) {
  const double along = std::abs(direction[static_cast<Eigen::Index>(axis)]);
  return along > plane_tolerance && along < 1.0 - plane_tolerance;
}

void check_symmetric_body(const BodySpecification& body, const std::string& path, const FluidCase& fluid,
                          std::size_t axis, Problems& problems) {
  const auto normal = static_cast<Eigen::Index>(axis);
  const std::string plane = std::string("symmetry plane ") + axis_names[axis];
  if (!lies_on(body, fluid, axis)) {
    const double beyond_m = body.position_m[normal] + half_extents_m(body)[normal] - middle_m(fluid, axis);
    if (beyond_m > plane_tolerance * fluid.cell_size_m)
      problems.error(path, "body '" + body.name + "' is " +
                               length_text(std::abs(body.position_m[normal] - middle_m(fluid, axis))) + " off " +
                               plane +
                               " and reaches beyond it (a body lies on the plane, or all of it in the lower half and "
                               "its mirror image in the upper). Move it, or remove the plane.");
    return;
  }
  if (body.shape.kind == ShapeKind::mesh || body.shape.kind == ShapeKind::compound) {
    problems.error(path, "body '" + body.name + "' has shape " + word_of(body.shape) + " on " + plane +
                             " (whether it is its own mirror image is not known). Put all of it into the lower half, "
                             "or remove the plane.");
  }
  const Eigen::Matrix3d axes = rotation_matrix(body.orientation_wxyz);
  bool tilted = has_orientation(body.shape) && oblique(body_axis(body), axis);
  if (!is_round(body.shape) && body.shape.kind != ShapeKind::cylinder)
    for (int own = 0; own < 2; ++own) tilted = tilted || oblique(axes.col(own), axis);
  if (tilted) {
    problems.error(path,
                   "body '" + body.name + "' is tilted against " + plane +
                       " (it is not its own mirror image). Turn it into or across the plane, or remove the plane.");
  }
  if (body.motion == MotionKind::axis && oblique(body.axis, axis)) {
    problems.error(path, "body '" + body.name + "' may move along an axis oblique to " + plane +
                             " (forces within the plane would push it off). Turn the axis into or across the plane, or "
                             "remove the plane.");
  }
  Eigen::Vector3d forbidden_spin = body.angular_velocity_rad_per_s;
  forbidden_spin[normal] = 0.0;
  if (body.velocity_m_per_s[normal] != 0.0 || !forbidden_spin.isZero(0.0)) {
    problems.error(path,
                   "body '" + body.name + "' moves across " + plane +
                       " (its mirror image moves the other way). Give it a symmetric motion, or remove the plane.");
  }
}

/// What ties a body on the plane to one beside it would tie it to the mirror image too, and what pulls at a
/// point off the plane would pull at that point's image.
/// @param joint  a SpringSpecification, a JointSpecification, or an ActuatorSpecification of a pair
void check_symmetric_joint(const auto& joint, const std::string& what, const std::string& path,
                           const Assembly& assembly, const FluidCase& fluid, std::size_t axis, Problems& problems) {
  if (joint.body_A < 0 || joint.body_B < 0) return;
  const auto& A = assembly.bodies[static_cast<std::size_t>(joint.body_A)];
  const auto& B = assembly.bodies[static_cast<std::size_t>(joint.body_B)];
  if (lies_on(A, fluid, axis) != lies_on(B, fluid, axis)) {
    problems.error(path, what + " ties '" + A.name + "' to '" + B.name +
                             "', only one of which lies on symmetry plane " + axis_names[axis] +
                             " (its mirror image is not computed). Remove the plane.");
    return;
  }
  if (!lies_on(A, fluid, axis)) return;
  const auto normal = static_cast<Eigen::Index>(axis);
  const double off_A_m = std::abs(in_world(A, joint.anchor_A_m)[normal]);
  const double off_B_m = std::abs(in_world(B, joint.anchor_B_m)[normal]);
  if (std::max(off_A_m, off_B_m) <= plane_tolerance * fluid.cell_size_m) return;
  problems.error(
      path, what + " is anchored to '" + (off_A_m >= off_B_m ? A : B).name + "' " +
                length_text(std::max(off_A_m, off_B_m)) + " off symmetry plane " + axis_names[axis] +
                " (it would turn the body or pull it off the plane). Anchor it on the plane, or remove the plane.");
}

/// The motion that a joint leaves must keep bodies on the plane.
void check_symmetric_axis(const JointSpecification& joint, const std::string& path, const Assembly& assembly,
                          const FluidCase& fluid, std::size_t axis, Problems& problems) {
  if (!has_axis(joint.kind) || joint.body_A < 0) return;
  const BodySpecification& A = assembly.bodies[static_cast<std::size_t>(joint.body_A)];
  if (!lies_on(A, fluid, axis)) return;
  const double across = std::abs(in_world(A, joint.axis)[static_cast<Eigen::Index>(axis)]);
  const bool turns = joint.kind == JointKind::hinge;
  if ((turns ? 1.0 - across : across) <= plane_tolerance) return;
  problems.reject(path + ".axis", std::string("is ") + (turns ? "not along " : "not across ") + axis_names[axis] +
                                      " (symmetry plane " + axis_names[axis] +
                                      " allows no other motion). Change the axis, or remove the plane.");
}

/// A bend between a body on the plane and two beside it on one side would have a mirror image of its own.
void check_symmetric_bend(const BendSpecification& bend, const std::string& path, const Assembly& assembly,
                          const FluidCase& fluid, std::size_t axis, Problems& problems) {
  if (std::min({bend.body_A, bend.body_B, bend.body_C}) < 0) return;
  const auto on_plane = [&](int body) { return lies_on(assembly.bodies[static_cast<std::size_t>(body)], fluid, axis); };
  if (on_plane(bend.body_A) == on_plane(bend.body_B) && on_plane(bend.body_B) == on_plane(bend.body_C)) return;
  problems.reject(path, std::string("is between bodies on and off symmetry plane ") + axis_names[axis] +
                            " (its mirror image is not computed). Remove the plane.");
}

/// A force must lie in the plane, a torque across it.
void check_symmetric_actuator(const ActuatorSpecification& actuator, const std::string& path, const Assembly& assembly,
                              const FluidCase& fluid, std::size_t axis, Problems& problems) {
  if (actuator.kind == ActuatorKind::pair_force)
    return check_symmetric_joint(actuator, "a pair force", path, assembly, fluid, axis, problems);
  if (actuator.body_A < 0 || actuator.kind == ActuatorKind::control) return;
  const BodySpecification& body = assembly.bodies[static_cast<std::size_t>(actuator.body_A)];
  if (!lies_on(body, fluid, axis)) return;
  const bool turns = actuator.kind == ActuatorKind::body_force || actuator.kind == ActuatorKind::body_torque;
  const bool torque = actuator.kind == ActuatorKind::body_torque || actuator.kind == ActuatorKind::world_torque;
  const Eigen::Vector3d direction = turns ? in_world(body, actuator.direction) : actuator.direction;
  const double across = std::abs(direction[static_cast<Eigen::Index>(axis)]);
  if ((torque ? 1.0 - across : across) <= plane_tolerance) return;
  const std::string name = axis_names[axis];
  const std::string key = path + ".direction";  // arms have pair forces only
  problems.error(key, key + (torque ? " is a torque not along " : " has a component along ") + name +
                          " (symmetry plane " + name + " allows none). Change its direction, or remove the plane.");
}

/// Without cells bodies on a plane are computed whole, which is the same, but no mirror images.
void check_images_not_computed(const FluidCase& fluid, const Assembly& assembly, std::size_t axis, Problems& problems) {
  const std::string plane = std::string("symmetry plane ") + axis_names[axis];
  if (middle_m(fluid, axis) == 0.0) {
    problems.error("fluid.symmetry_planes", plane +
                                                " has no position (it passes through the middle of the domain). Give "
                                                "fluid.domain_cells and fluid.cell_size_m, or remove the plane.");
    return;
  }
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i) {
    if (lies_on(assembly.bodies[i], fluid, axis)) continue;
    problems.error(assembly.body_paths[i], "body '" + assembly.bodies[i].name + "' lies beside " + plane +
                                               " (solver: " + name_of(solver_names, fluid.solver) +
                                               " computes no mirror images). Give its image as a body too and remove "
                                               "the plane, or use solver: lattice_boltzmann.");
  }
}

}  // namespace

void check_symmetry(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const FluidCase& fluid = the_case.fluid;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!fluid.symmetry_planes[axis] || fluid.solver == FluidSolverChoice::external) continue;
    if (fluid.solver == FluidSolverChoice::lattice_boltzmann) {
      check_symmetric_faces(fluid, axis, problems);
      check_symmetric_vector(fluid.body_force_N_per_m3, axis, "fluid.body_force_N_per_m3", problems);
      check_symmetric_vector(fluid.initial_flow.velocity_m_per_s, axis, "fluid.initial_flow.velocity_m_per_s",
                             problems);
    } else {
      check_images_not_computed(fluid, assembly, axis, problems);
    }
    check_symmetric_vector(the_case.body.gravity_m_per_s2, axis, "gravity_m_per_s2", problems);
    for (std::size_t i = 0; i < assembly.bodies.size(); ++i)
      check_symmetric_body(assembly.bodies[i], assembly.body_paths[i], fluid, axis, problems);
    for (std::size_t i = 0; i < assembly.springs.size(); ++i)
      check_symmetric_joint(assembly.springs[i], "a spring", assembly.spring_paths[i], assembly, fluid, axis, problems);
    for (std::size_t i = 0; i < assembly.joints.size(); ++i) {
      const std::string path = "joints." + std::to_string(i);
      JointSpecification joint = assembly.joints[i];
      check_symmetric_axis(joint, path, assembly, fluid, axis, problems);
      if (joint.body_B < 0) {  // the world has no mirror image: what the body's end must do is left
        joint.body_B = joint.body_A;
        joint.anchor_B_m = joint.anchor_A_m;
      }
      check_symmetric_joint(joint, "a joint", path, assembly, fluid, axis, problems);
    }
    for (std::size_t i = 0; i < assembly.bends.size(); ++i)
      check_symmetric_bend(assembly.bends[i], assembly.bend_paths[i], assembly, fluid, axis, problems);
    for (std::size_t i = 0; i < assembly.drive.size(); ++i) {
      if (assembly.drive_springs[i] >= 0) continue;  // a rest length acts where its spring does
      check_symmetric_actuator(assembly.drive[i].actuator, assembly.drive_paths[i], assembly, fluid, axis, problems);
    }
  }
}

}  // namespace copepod::coupler
