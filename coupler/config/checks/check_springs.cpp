#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

#include <Eigen/Geometry>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "contract/words.hpp"

namespace copepod::coupler {

namespace {

/// Reports a spring or pair force whose ends coincide at the start, or that has one body only.
/// @return distance of its ends [m]; 0 if there was something to report
double length_of_joint(const auto& joint, const std::string& what, const std::string& path, const Assembly& assembly,
                       Problems& problems) {
  const BodySpecification& A = assembly.bodies[joint.body_A];
  const BodySpecification& B = assembly.bodies[joint.body_B];
  if (joint.body_A == joint.body_B) {
    problems.reject(path + ".bodies",
                    "names '" + A.name + "' twice (" + what + " needs two ends). Name two different bodies.");
    return 0.0;
  }
  const double length_m =
      (B.position_m + in_world(B, joint.anchor_B_m) - A.position_m - in_world(A, joint.anchor_A_m)).norm();
  if (length_m == 0.0) {
    problems.error(path, what + " between '" + A.name + "' and '" + B.name +
                             "' has no length at the start (it has no direction). Move its ends apart.");
  }
  return length_m;
}

void check_bends(const Assembly& assembly, Problems& problems) {
  for (std::size_t i = 0; i < assembly.bends.size(); ++i) {
    const BendSpecification& bend = assembly.bends[i];
    if (std::min({bend.body_A, bend.body_B, bend.body_C}) < 0) continue;  // reported by check_names
    if (bend.body_A == bend.body_B || bend.body_B == bend.body_C || bend.body_C == bend.body_A) {
      problems.error(
          assembly.bend_paths[i] + ".bodies",
          assembly.bend_paths[i] + " names a body twice (an angle needs three). Name three different bodies.");
      continue;
    }
    const auto arm = [&](int body) -> Eigen::Vector3d {
      return assembly.bodies[body].position_m - assembly.bodies[bend.body_B].position_m;
    };
    const Eigen::Vector3d a = arm(bend.body_A).normalized();
    const Eigen::Vector3d c = arm(bend.body_C).normalized();
    constexpr double parallel_rad = 1e-9;
    const double angle_rad = std::atan2(a.cross(c).norm(), a.dot(c));
    const bool parallel = std::min(angle_rad, std::numbers::pi - angle_rad) < parallel_rad;
    if (parallel && std::abs(angle_rad - bend.rest_angle_rad) > parallel_rad) {
      problems.reject(assembly.bend_paths[i],
                      "starts with parallel arms, away from its rest angle (its forces have no direction). Start at "
                      "another angle, or use a rest angle of 180 degrees for straight arms.");
    }
  }
}

void check_pairs(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const std::size_t of_swimmers = assembly.drive.size() - the_case.actuators.size();
  for (std::size_t i = 0; i < the_case.actuators.size(); ++i) {
    const NamedActuator& actuator = the_case.actuators[i];
    if (!actuator.rest_length || assembly.drive_springs[of_swimmers + i] >= 0) continue;
    if (actuator.bodies[0] == actuator.bodies[1]) continue;  // reported below
    const std::string path = "actuators." + std::to_string(i) + ".bodies";
    problems.reject(
        path, "are '" + actuator.bodies[0] + "' and '" + actuator.bodies[1] +
                  "' (no spring joins them whose rest length could vary). Add the spring, or use kind: pair_force.");
  }
  for (std::size_t i = 0; i < assembly.drive.size(); ++i) {
    const ActuatorSpecification& actuator = assembly.drive[i].actuator;
    const bool rest_length = assembly.drive_springs[i] >= 0;  // its spring is checked
    if (actuator.kind != ActuatorKind::pair_force || rest_length || std::min(actuator.body_A, actuator.body_B) < 0)
      continue;
    length_of_joint(actuator, "a pair force", assembly.drive_paths[i], assembly, problems);
  }
}

/// Two arms of a swimmer between the same beads: perhaps one of them was meant to join others.
void check_arms(const Case& the_case, Problems& problems) {
  for (std::size_t i = 0; i < the_case.swimmers.size(); ++i) {
    const Swimmer& swimmer = the_case.swimmers[i];
    std::set<std::pair<int, int>> joined;
    for (std::size_t arm = 0; arm < swimmer.arms.size(); ++arm) {
      const auto [A, B] = std::minmax(swimmer.arms[arm].body_A, swimmer.arms[arm].body_B);
      if (joined.emplace(A, B).second) continue;
      const std::string path = path_of_swimmer(the_case, i) + ".arms." + std::to_string(arm);
      problems.warn(
          path, "joins '" + swimmer.beads[A].name + "' and '" + swimmer.beads[B].name +
                    "' like an arm before it (their springs act side by side). Name other beads, or make it one arm.");
    }
  }
}

/// What acts on bodies that the coupler moves.
void check_prescribed(const Assembly& assembly, Problems& problems) {
  const auto check = [&](std::initializer_list<int> bodies, const std::string& path) {
    for (const auto& [prescribed, signal] : assembly.prescribed) {
      if (std::ranges::find(bodies, prescribed) == bodies.end()) continue;
      const std::string& name = assembly.bodies[prescribed].name;
      problems.reject(path, "acts on body '" + name +
                                "' (its motion is a function of time: the coupler moves it, not the body component). "
                                "Remove it, or prescribe constant velocities with motion: prescribed.");
      return;
    }
  };
  for (std::size_t i = 0; i < assembly.springs.size(); ++i)
    check({assembly.springs[i].body_A, assembly.springs[i].body_B}, assembly.spring_paths[i]);
  for (std::size_t i = 0; i < assembly.bends.size(); ++i)
    check({assembly.bends[i].body_A, assembly.bends[i].body_B, assembly.bends[i].body_C}, assembly.bend_paths[i]);
  for (std::size_t i = 0; i < assembly.drive.size(); ++i)
    check({assembly.drive[i].actuator.body_A, assembly.drive[i].actuator.body_B}, assembly.drive_paths[i]);
}

/// What limits the step, and where the case has it.
struct Limiting {
  std::string what;
  std::string path;
  bool bend = false;
};

Limiting limiting_of(std::size_t index, const Case& the_case, const Assembly& assembly) {
  const auto name = [&](int body) { return "'" + assembly.bodies[body].name + "'"; };
  if (index < assembly.springs.size()) {
    const SpringSpecification& spring = assembly.springs[index];
    return {"the spring between " + name(spring.body_A) + " and " + name(spring.body_B) + " is too stiff or too damped",
            assembly.spring_paths[index]};
  }
  index -= assembly.springs.size();
  if (index < assembly.bends.size()) {
    const BendSpecification& bend = assembly.bends[index];
    return {
        "the bend of " + name(bend.body_A) + ", " + name(bend.body_B) + " and " + name(bend.body_C) + " is too stiff",
        assembly.bend_paths[index], true};
  }
  index -= assembly.bends.size();
  return {"the spring of joint '" + the_case.joints[index].name + "' is too stiff or too damped",
          "joints." + std::to_string(index)};
}

/// @return whether the bodies of a joint are two, not prescribed, and one of them can move
bool check_jointed_bodies(const NamedJoint& named, const JointSpecification& joint, const std::string& path,
                          const Assembly& assembly, Problems& problems) {
  if (named.bodies[0] == named.bodies[1]) {
    problems.reject(
        path, "names '" + named.bodies[0] + "' twice (a joint has two ends). Name two bodies, or a body and world.");
    return false;
  }
  for (const int body : {joint.body_A, joint.body_B}) {
    if (body < 0 || assembly.bodies[body].motion != MotionKind::prescribed) continue;
    problems.reject(path,
                    "names '" + assembly.bodies[body].name +
                        "' (its motion is prescribed, it cannot follow a joint). Use motion: free, fixed or axis.");
    return false;
  }
  const auto can_move = [&](int body) { return body >= 0 && moves_under_loads(assembly.bodies[body]); };
  if (can_move(joint.body_A) || can_move(joint.body_B)) return true;
  problems.reject(path, "joins what cannot move. Remove the joint, or use motion: free.");
  return false;
}

/// A rod needs a direction.
void check_length(const JointSpecification& joint, const std::string& path, const Assembly& assembly,
                  Problems& problems) {
  const auto end_m = [&assembly](int number, const Eigen::Vector3d& anchor_m) -> Eigen::Vector3d {
    if (number < 0) return anchor_m;
    const BodySpecification& body = assembly.bodies[number];
    return body.position_m + in_world(body, anchor_m);
  };
  constexpr double shortest = 1e-6;  // radii
  const double radius_m = assembly.bodies[joint.body_A].shape.radius_m;
  if ((end_m(joint.body_A, joint.anchor_A_m) - end_m(joint.body_B, joint.anchor_B_m)).norm() > shortest * radius_m)
    return;
  problems.error(path + ".anchors_m",
                 path + " is a rod without length (it has no direction). Move an anchor, or use kind: ball.");
}

/// Of a hinge or slider.
void check_limits(const NamedJoint& joint, const std::string& path, Problems& problems) {
  const bool hinge = joint.kind == JointKind::hinge;
  const std::string at = path + (hinge ? ".limits_rad" : ".limits_m");
  if (joint.lowest > 0.0 || joint.highest < 0.0)
    problems.reject(at, "leaves the start out (motion counts from there, as 0). Write [lowest, highest] around 0.");
  if (hinge && std::max(std::abs(joint.lowest), std::abs(joint.highest)) > 3.0)
    problems.reject(at, "is wider than 3 (angles are those within half a turn). Use -3 to 3 at most.");
  if (joint.signal) {
    problems.reject(path + ".signal",
                    "moves a joint that has limits (it goes where the signal goes). Remove one of them.");
  }
}

/// Of a joint that is driven.
void check_signal(const Signal& signal, Integrator integrator, std::int64_t steps, const std::string& path,
                  Problems& problems) {
  if (signal.kind == SignalKind::square)
    problems.reject(path, "is square (bodies cannot jump). Use trapezoid, with a rise_fraction.");
  for (const std::int64_t step : {signal.start_step, signal.stop_step}) {
    if (step == 0 || step >= steps || signal.kind == SignalKind::square) continue;
    const double jump = value_of(signal, step, 0.0) - value_of(signal, step - 1, 1.0);
    if (std::abs(jump) <= 1e-9 * std::abs(signal.amplitude)) continue;
    problems.reject(path,
                    "jumps by " + rounded_text(jump) + " at step " + std::to_string(step) +
                        (step == signal.start_step ? ", as it starts" : ", as it stops") +
                        " (bodies cannot jump). Start and stop it where it is 0, or give ramp_steps for the start.");
  }
  if (integrator != Integrator::runge_kutta_4) {
    problems.reject(path, std::string("is given with integrator: ") + name_of(integrator_names, integrator) +
                              " (the motion of a joint takes the middle of each step). Use runge_kutta_4.");
  }
}

}  // namespace

void check_springs(const Case& the_case, const Assembly& assembly, Problems& problems) {
  check_prescribed(assembly, problems);
  check_bends(assembly, problems);
  check_pairs(the_case, assembly, problems);
  check_arms(the_case, problems);
  for (std::size_t i = 0; i < assembly.springs.size(); ++i) {
    const SpringSpecification& spring = assembly.springs[i];
    if (spring.body_A < 0 || spring.body_B < 0) continue;  // reported by check_names
    const std::string& path = assembly.spring_paths[i];
    const double length_m = length_of_joint(spring, "a spring", path, assembly, problems);
    const double stretch = std::abs(length_m - spring.rest_length_m);
    if (length_m > 0.0 && stretch > 0.5 * std::max(spring.rest_length_m, length_m)) {
      problems.warning(path, "a spring of rest length " + length_text(spring.rest_length_m) + " starts at " +
                                 length_text(length_m) +
                                 " (it will jerk its bodies). Check rest_length_m and positions.");
    }
  }
}
void check_stiffness(const Case& the_case, const Assembly& assembly, Problems& problems) {
  const bool ours = the_case.body.solver == BodySolverChoice::own && the_case.services.body_command.empty();
  if (!ours || assembly.springs.size() + assembly.bends.size() + assembly.joints.size() == 0) return;
  const Integrator integrator = the_case.body.integrator;
  std::vector<BodySpecification> bodies = assembly.bodies;
  if (const VirtualMasses virtual_mass = virtual_masses(the_case, assembly); !virtual_mass.returns) {
    for (std::size_t i = 0; i < bodies.size(); ++i) bodies[i].mass_kg += virtual_mass.mass_kg[i];
  }
  const FastestSprings fastest = fastest_springs(bodies, assembly.springs, assembly.bends, assembly.joints, integrator);
  constexpr double close = 0.8;
  if (the_case.step_s <= close * fastest.together.largest_step_s) return;
  const bool diverges = the_case.step_s > fastest.alone.largest_step_s;
  const StepLimit& limit = diverges ? fastest.alone : fastest.together;
  const auto [what, path, bend] = limiting_of(limit.spring, the_case, assembly);
  const std::string found = what + " for a step of " + rounded_text(the_case.step_s) + " s (" +
                            name_of(integrator_names, integrator) + (diverges ? " diverges" : " may diverge") +
                            " above " + rounded_text(limit.largest_step_s) + " s";
  const std::string remedy = bend ? "Use a smaller step, a softer bend, longer arms or heavier bodies."
                                  : "Use a smaller step, a softer spring, less damping or heavier bodies.";
  if (diverges) {
    problems.error(path, found + "). " + remedy);
  } else {
    problems.warning(path, found + ": close to it oscillations are wrong). " + remedy);
  }
}

void check_joints(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (the_case.joints.empty()) return;
  const auto named_world = std::ranges::find(assembly.bodies, NamedJoint::world, &BodySpecification::name);
  if (named_world != assembly.bodies.end())
    return problems.error(assembly.body_paths[named_world - assembly.bodies.begin()],
                          "a body has the name 'world' (in joints it means no body). Rename it.");
  std::set<std::string> names;
  for (std::size_t i = 0; i < the_case.joints.size(); ++i) {
    const std::string path = "joints." + std::to_string(i);
    const NamedJoint& named = the_case.joints[i];
    if (!names.insert(named.name).second)
      problems.reject(path + ".name", "is '" + named.name + "' (another joint has this name). Rename it.");
    const JointSpecification& joint = assembly.joints[i];
    if (joint.kind == JointKind::model && the_case.body.model.text.empty()) {
      problems.reject(path + ".kind", "is model (there is no body.model). Use another kind.");
    }
    if (named.signal && (named.stiffness > 0.0 || named.damping > 0.0)) {
      problems.reject(path + ".signal",
                      "moves a joint that has a spring or damper (it would change nothing). Remove one of them.");
    }
    if (joint.has_limits()) check_limits(named, path, problems);
    if (named.signal) check_signal(*named.signal, the_case.body.integrator, the_case.steps, path + ".signal", problems);
    if (!check_jointed_bodies(named, joint, path + ".bodies", assembly, problems)) continue;
    if (joint.kind == JointKind::distance) check_length(joint, path, assembly, problems);
  }
}

}  // namespace copepod::coupler
