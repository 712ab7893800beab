#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <unordered_map>

#include "config/sections/sections.hpp"
#include "geometry/rotation.hpp"
#include "geometry/shapes/solid.hpp"

namespace copepod::coupler {
namespace {

/// The shape moved by a vector, in its own frame.
Shape moved(const Shape& shape, const Eigen::Vector3d& by_m) {
  Shape result = shape;
  if (by_m.isZero(0.0)) return result;
  if (shape.kind == ShapeKind::mesh) {
    result.mesh = std::make_shared<const TriangleMesh>(shape.mesh->vertices_m.colwise() + by_m, shape.mesh->triangles);
  } else if (shape.kind == ShapeKind::compound) {
    for (ShapePart& part : result.parts) part.position_m += by_m;
  } else {
    const double radius_m = std::cbrt(volume_m3(shape) / (4.0 / 3.0 * std::numbers::pi));
    result = {.kind = ShapeKind::compound, .radius_m = radius_m, .parts = {{.shape = shape, .position_m = by_m}}};
  }
  return result;
}

bool is_at_the_centre(const ShapePart& part) {
  return part.position_m.isZero(0.0) && part.orientation_wxyz == Eigen::Vector4d(1, 0, 0, 0);
}

/// The body by its centre of mass, with its inertia. A compound of one part in its middle is this part.
BodySpecification referred_to_centre_of_mass(const GivenBody& given) {
  BodySpecification body = static_cast<const BodySpecification&>(given);
  if (body.shape.kind == ShapeKind::compound && body.shape.parts.size() == 1 && is_at_the_centre(body.shape.parts[0]))
    body.shape = Shape(body.shape.parts[0].shape);
  Eigen::Vector3d centre_m = given.center_of_mass_m;
  if (body.inertia_kg_m2.empty()) {
    if (is_round(body.shape)) return body;
    const VolumeMoments moments = make_solid(body.shape)->moments();
    centre_m = moments.centre();
    if (body.shape.kind != ShapeKind::mesh && body.shape.kind != ShapeKind::compound) centre_m.setZero();
    const Eigen::Matrix3d I =
        body.mass_kg / moments.volume * moments.moved(Eigen::Matrix3d::Identity(), -centre_m).inertia();
    body.inertia_kg_m2 = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  }
  if (centre_m.isZero(0.0)) return body;
  body.shape = moved(body.shape, -centre_m);
  body.position_m += rotation_matrix(body.orientation_wxyz) * centre_m;
  return body;
}

void add_swimmer_bodies(const Swimmer& swimmer, const std::string& path, Assembly& assembly) {
  const Eigen::Matrix3d R_WS = rotation_matrix(swimmer.orientation_wxyz);
  const bool turned = swimmer.orientation_wxyz != Eigen::Vector4d(1, 0, 0, 0);  // else −0 would become 0
  assembly.first_bodies.push_back(static_cast<int>(assembly.bodies.size()));
  for (const Bead& bead : swimmer.beads) {
    assembly.body_paths.push_back(path + ".beads." + std::to_string(&bead - swimmer.beads.data()));
    GivenBody body = bead;
    body.name = swimmer.name + "." + bead.name;
    body.position_m = swimmer.center_m + R_WS * bead.position_m;
    if (turned) body.orientation_wxyz = product(swimmer.orientation_wxyz, bead.orientation_wxyz);
    assembly.bodies.push_back(referred_to_centre_of_mass(body));
  }
}

/// A signal of a swimmer, late by the swimmer's part of its period; one without a period is not.
Signal delayed(Signal signal, double phase_deg) {
  const double turns = phase_deg / 360.0;
  const double lag_steps = (turns - std::floor(turns)) * static_cast<double>(signal.period_steps);
  const auto whole_steps = static_cast<std::int64_t>(std::ceil(lag_steps));
  signal.lag_steps += lag_steps;
  signal.start_step += whole_steps;
  if (signal.stop_step != Signal::never) signal.stop_step += whole_steps;
  return signal;
}

/// A pair force along spring number `index`; one that stands for the spring's rest length L₀ + s has k s.
void add_drive_along(std::size_t index, Signal signal, bool rest_length, Assembly& assembly) {
  const SpringSpecification& spring = assembly.springs[index];
  DrivenActuator& driven = assembly.drive.emplace_back();
  driven.actuator.body_A = spring.body_A;
  driven.actuator.body_B = spring.body_B;
  driven.actuator.anchor_A_m = spring.anchor_A_m;
  driven.actuator.anchor_B_m = spring.anchor_B_m;
  driven.signal = std::move(signal);
  if (rest_length) driven.signal.amplitude *= spring.stiffness_N_per_m;
  assembly.drive_springs.push_back(rest_length ? static_cast<int>(index) : -1);
}

void add_swimmer_arms(const Swimmer& swimmer, int first_body, const std::string& path, Assembly& assembly) {
  for (std::size_t i = 0; i < swimmer.arms.size(); ++i) {
    const Arm& arm = swimmer.arms[i];
    const std::string arm_path = path + ".arms." + std::to_string(i);
    SpringSpecification& spring = assembly.springs.emplace_back(arm);
    for (int* body : {&spring.body_A, &spring.body_B}) *body += first_body;
    assembly.spring_paths.push_back(swimmer.three_beads ? path + ".spring" : arm_path);
    if (!arm.drive) continue;
    add_drive_along(assembly.springs.size() - 1, delayed(arm.drive->signal, swimmer.phase_deg),
                    arm.drive->kind == DriveKind::rest_length, assembly);
    assembly.drive_paths.push_back(swimmer.three_beads ? path + ".stroke" : arm_path);
    assembly.signal_paths.push_back(swimmer.three_beads ? path + ".stroke" : arm_path + ".drive.signal");
  }
  for (std::size_t i = 0; i < swimmer.bends.size(); ++i) {
    BendSpecification& bend = assembly.bends.emplace_back(swimmer.bends[i]);
    for (int* body : {&bend.body_A, &bend.body_B, &bend.body_C}) *body += first_body;
    assembly.bend_paths.push_back(path + ".bends." + std::to_string(i));
  }
}

using BodyNumbers = std::unordered_map<std::string, int>;

int number_of(const BodyNumbers& numbers, const std::string& name) {
  const auto found = numbers.find(name);
  return found == numbers.end() ? -1 : found->second;
}

void add_case_springs_and_bends(const Case& the_case, const BodyNumbers& numbers, Assembly& assembly) {
  for (std::size_t i = 0; i < the_case.springs.size(); ++i) {
    const NamedSpring& named = the_case.springs[i];
    SpringSpecification& spring = assembly.springs.emplace_back(named);
    spring.body_A = number_of(numbers, named.bodies[0]);
    spring.body_B = number_of(numbers, named.bodies[1]);
    assembly.spring_paths.push_back("springs." + std::to_string(i));
  }
  for (std::size_t i = 0; i < the_case.bends.size(); ++i) {
    const NamedBend& named = the_case.bends[i];
    BendSpecification& bend = assembly.bends.emplace_back(named);
    bend.body_A = number_of(numbers, named.bodies[0]);
    bend.body_B = number_of(numbers, named.bodies[1]);
    bend.body_C = number_of(numbers, named.bodies[2]);
    assembly.bend_paths.push_back("bends." + std::to_string(i));
  }
}

/// Anchor and axis of the start in the frames of the bodies:
///   p_BQ = R_BW (p_WQ − p_WB)                                  [docs/theory_bodies.md]
/// The world is always the second body. Where it was the first, the axis is turned round, for the same motion.
JointSpecification joint_of(const NamedJoint& named, const BodyNumbers& numbers, const Assembly& assembly) {
  const bool exchanged = named.bodies[0] == NamedJoint::world;
  JointSpecification joint = static_cast<const JointSpecification&>(named);
  joint.body_A = number_of(numbers, named.bodies[exchanged ? 1 : 0]);
  joint.body_B = number_of(numbers, named.bodies[exchanged ? 0 : 1]);
  if (joint.kind == JointKind::model) return joint;
  if (exchanged) std::swap(joint.anchor_A_m, joint.anchor_B_m);
  const auto in_frame_of = [&assembly](int number, const Eigen::Vector3d& place_m) -> Eigen::Vector3d {
    if (number < 0) return place_m;
    const BodySpecification& body = assembly.bodies[number];
    return rotation_matrix(body.orientation_wxyz).transpose() * (place_m - body.position_m);
  };
  if (joint.kind != JointKind::distance) {
    joint.anchor_A_m = in_frame_of(joint.body_A, named.anchor_m);
    joint.anchor_B_m = in_frame_of(joint.body_B, named.anchor_m);
  }
  if (!has_axis(joint.kind) || joint.body_A < 0) return joint;
  const BodySpecification& A = assembly.bodies[joint.body_A];
  joint.axis = rotation_matrix(A.orientation_wxyz).transpose() * (exchanged ? -named.axis : named.axis);
  return joint;
}

void add_case_joints(const Case& the_case, const BodyNumbers& numbers, Assembly& assembly) {
  for (std::size_t i = 0; i < the_case.joints.size(); ++i) {
    const NamedJoint& named = the_case.joints[i];
    const JointSpecification& joint = assembly.joints.emplace_back(joint_of(named, numbers, assembly));
    if (!named.signal) continue;
    DrivenActuator& driven = assembly.drive.emplace_back();
    driven.actuator.kind = ActuatorKind::joint_motion;
    driven.actuator.body_A = joint.body_A;
    driven.actuator.body_B = joint.body_B;
    driven.actuator.joint = static_cast<int>(i);
    driven.signal = *named.signal;
    assembly.drive_springs.push_back(-1);
    assembly.drive_paths.push_back("joints." + std::to_string(i));
    assembly.signal_paths.push_back(assembly.drive_paths.back() + ".signal");
  }
}

void add_case_actuators(const Case& the_case, const BodyNumbers& numbers, Assembly& assembly) {
  std::map<std::pair<int, int>, std::size_t> springs;  // the first between two bodies
  for (std::size_t i = 0; i < assembly.springs.size(); ++i)
    springs.emplace(std::minmax(assembly.springs[i].body_A, assembly.springs[i].body_B), i);
  for (std::size_t i = 0; i < the_case.actuators.size(); ++i) {
    const NamedActuator& named = the_case.actuators[i];
    const int body_A = named.bodies.empty() ? 0 : number_of(numbers, named.bodies[0]);
    const int body_B = named.bodies.size() > 1 ? number_of(numbers, named.bodies[1]) : -1;
    const auto spring = named.rest_length ? springs.find(std::minmax(body_A, body_B)) : springs.end();
    if (spring != springs.end()) {
      add_drive_along(spring->second, named.signal, true, assembly);
    } else {
      assembly.drive.push_back({static_cast<const ActuatorSpecification&>(named), named.signal});
      assembly.drive.back().actuator.body_A = body_A;
      assembly.drive.back().actuator.body_B = body_B;
      assembly.drive_springs.push_back(-1);
    }
    assembly.drive_paths.push_back("actuators." + std::to_string(i));
    assembly.signal_paths.push_back(assembly.drive_paths.back() + ".signal");
  }
}

}  // namespace

Assembly assemble(const Case& the_case) {
  Assembly assembly;
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    const std::string path = path_of_swimmer(the_case, i);
    add_swimmer_bodies(swimmer, path, assembly);
    add_swimmer_arms(swimmer, assembly.first_bodies.back(), path, assembly);
  }
  for (std::size_t i = 0; i < the_case.bodies.size(); ++i) {
    const std::optional<Signal>& signal = the_case.bodies[i].signal;
    if (signal) assembly.prescribed.push_back({static_cast<int>(assembly.bodies.size()), *signal});
    assembly.bodies.push_back(referred_to_centre_of_mass(the_case.bodies[i]));
    assembly.body_paths.push_back("bodies." + std::to_string(i));
  }
  BodyNumbers numbers;  // if two bodies share a name, which is an error, the first one counts
  for (std::size_t i = 0; i < assembly.bodies.size(); ++i)
    numbers.emplace(assembly.bodies[i].name, static_cast<int>(i));
  for (const NamedGroup& named : the_case.groups) {
    std::vector<int>& bodies = assembly.groups.emplace_back();
    for (const std::string& name : named.bodies) bodies.push_back(number_of(numbers, name));
  }
  add_case_springs_and_bends(the_case, numbers, assembly);
  add_case_joints(the_case, numbers, assembly);
  add_case_actuators(the_case, numbers, assembly);
  for (const PrescribedBody& each : assembly.prescribed)
    assembly.drive_paths.push_back(assembly.body_paths[each.body] + ".motion.prescribed");
  return assembly;
}

}  // namespace copepod::coupler
