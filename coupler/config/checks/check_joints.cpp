#include <algorithm>
#include <cmath>
#include <set>

#include "config/checks/checks.hpp"
#include "config/placement/geometry.hpp"
#include "config/sections/case.hpp"
#include "contract/number_text.hpp"

namespace copepod::coupler {
namespace {

bool can_move(const Assembly& assembly, int body) {
  if (body < 0) return false;
  const MotionKind motion = assembly.bodies[static_cast<std::size_t>(body)].motion;
  return motion == MotionKind::free || motion == MotionKind::axis;
}

/// @return whether the bodies of a joint are two, not prescribed, and one of them can move
bool check_jointed_bodies(const NamedJoint& named, const JointSpecification& joint, const std::string& path,
                          const Assembly& assembly, Problems& problems) {
  if (named.bodies[0] == named.bodies[1]) {
    problems.error(path, path + " names '" + named.bodies[0] +
                             "' twice (a joint has two ends). Name two bodies, or "
                             "a body and world.");
    return false;
  }
  for (const int body : {joint.body_A, joint.body_B}) {
    if (body < 0 || assembly.bodies[static_cast<std::size_t>(body)].motion != MotionKind::prescribed) continue;
    problems.error(path, path + " names '" + assembly.bodies[static_cast<std::size_t>(body)].name +
                             "' (its motion is prescribed, it cannot follow a joint). Use motion: free, fixed or "
                             "axis.");
    return false;
  }
  if (can_move(assembly, joint.body_A) || can_move(assembly, joint.body_B)) return true;
  problems.error(path, path + " joins what cannot move. Remove the joint, or use motion: free.");
  return false;
}

/// A rod needs a direction.
void check_length(const JointSpecification& joint, const std::string& path, const Assembly& assembly,
                  Problems& problems) {
  const auto end_m = [&assembly](int number, const Eigen::Vector3d& anchor_m) -> Eigen::Vector3d {
    if (number < 0) return anchor_m;
    const BodySpecification& body = assembly.bodies[static_cast<std::size_t>(number)];
    return body.position_m + in_world(body, anchor_m);
  };
  constexpr double shortest = 1e-6;  // radii
  const double radius_m = assembly.bodies[static_cast<std::size_t>(joint.body_A)].shape.radius_m;
  if ((end_m(joint.body_A, joint.anchor_A_m) - end_m(joint.body_B, joint.anchor_B_m)).norm() > shortest * radius_m)
    return;
  problems.error(path + ".anchors_m",
                 path + " is a rod without length (it has no direction). Move an anchor, or use kind: ball.");
}

/// Of a hinge or slider.
void check_limits(const NamedJoint& joint, const std::string& path, Problems& problems) {
  const bool hinge = joint.kind == JointKind::hinge;
  const std::string at = path + (hinge ? ".limits_rad" : ".limits_m");
  if (joint.limits[0] > 0.0 || joint.limits[1] < 0.0)
    problems.error(at,
                   at + " leaves the start out (motion counts from there, as 0). Write [lowest, highest] around 0.");
  if (hinge && !(joint.limits.cwiseAbs().maxCoeff() <= 3.0))
    problems.error(at, at + " is wider than 3 (angles are those within half a turn). Use -3 to 3 at most.");
  if (joint.signal) {
    problems.error(path + ".signal", path + ".signal moves a joint that has limits (it goes where the signal goes). " +
                                         "Remove one of them.");
  }
}

/// Of a joint that is driven.
void check_signal(const Signal& signal, Integrator integrator, std::int64_t steps, const std::string& path,
                  Problems& problems) {
  if (signal.kind == SignalKind::square)
    problems.error(path, path + " is square (bodies cannot jump). Use trapezoid, with a rise_fraction.");
  for (const std::int64_t step : {signal.start_step, signal.stop_step}) {
    if (step == 0 || step >= steps || signal.kind == SignalKind::square) continue;
    const double jump = value_of(signal, step, 0.0) - value_of(signal, step - 1, 1.0);
    if (std::abs(jump) <= 1e-9 * std::abs(signal.amplitude)) continue;
    problems.error(path,
                   path + " jumps by " + rounded_text(jump) + " at step " + std::to_string(step) +
                       (step == signal.start_step ? ", as it starts" : ", as it stops") +
                       " (bodies cannot jump). Start and stop it where it is 0, or give ramp_steps for the start.");
  }
  if (integrator != Integrator::runge_kutta_4) {
    problems.error(path, path + " is given with integrator: " + name_of(integrator_names, integrator) +
                             " (the motion of a joint takes the middle of each step). Use runge_kutta_4.");
  }
}

}  // namespace

void check_joints(const Case& the_case, const Assembly& assembly, Problems& problems) {
  if (the_case.joints.empty()) return;
  const auto named_world = std::ranges::find(assembly.bodies, NamedJoint::world, &BodySpecification::name);
  if (named_world != assembly.bodies.end()) {
    problems.error(assembly.body_paths[static_cast<std::size_t>(named_world - assembly.bodies.begin())],
                   "a body has the name 'world' (in joints it means no body). Rename it.");
    return;
  }
  std::set<std::string> names;
  for (std::size_t i = 0; i < the_case.joints.size(); ++i) {
    const std::string path = "joints." + std::to_string(i);
    const NamedJoint& named = the_case.joints[i];
    if (!names.insert(named.name).second)
      problems.error(path + ".name", path + ".name is '" + named.name + "' (another joint has this name). Rename it.");
    const JointSpecification& joint = assembly.joints[i];
    if (joint.kind == JointKind::model && the_case.body.model.text.empty()) {
      problems.error(path + ".kind", path + ".kind is model (there is no body.model). Use another kind.");
    }
    if (named.signal && (named.stiffness > 0.0 || named.damping > 0.0)) {
      problems.error(path + ".signal", path +
                                           ".signal moves a joint that has a spring or damper (it would change "
                                           "nothing). Remove one of them.");
    }
    if (joint.has_limits()) check_limits(named, path, problems);
    if (named.signal) check_signal(*named.signal, the_case.body.integrator, the_case.steps, path + ".signal", problems);
    if (!check_jointed_bodies(named, joint, path + ".bodies", assembly, problems)) continue;
    if (joint.kind == JointKind::distance) check_length(joint, path, assembly, problems);
  }
}

}  // namespace copepod::coupler
