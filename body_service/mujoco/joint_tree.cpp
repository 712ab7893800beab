#include "mujoco/joint_tree.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

namespace copepod::body {

namespace {

/// Those that must be edges first.
std::vector<int> by_need(const BodySetup& setup) {
  std::vector<int> edges(setup.joints.size());
  std::iota(edges.begin(), edges.end(), 0);
  std::ranges::stable_sort(edges, std::greater<>{}, [&](int joint) { return must_be_edge(setup, joint); });
  return edges;
}

}  // namespace

bool is_driven(const BodySetup& setup, int joint) {
  return std::ranges::any_of(setup.actuators, [joint](const ActuatorSpecification& actuator) {
    return actuator.kind == ActuatorKind::joint_motion && actuator.joint == joint;
  });
}

bool must_be_edge(const BodySetup& setup, int joint) {
  const JointSpecification& it = setup.joints[joint];
  return it.kind == JointKind::slider || it.kind == JointKind::distance || it.stiffness > 0.0 || it.damping > 0.0 ||
         it.has_limits() || is_driven(setup, joint);
}

/// Prim's algorithm [Bell Syst. Tech. J. 36, 1389, 1957].
JointTree joint_tree_of(const BodySetup& setup) {
  JointTree tree;
  tree.bodies.resize(setup.bodies.size());
  std::vector<bool> reached(setup.bodies.size(), false);
  const auto is_reached = [&](int body) { return body < 0 || reached[body]; };
  const auto attach = [&](int body, int parent, int joint) {
    tree.bodies[body].parent = parent;
    tree.bodies[body].joint = joint;
    (parent < 0 ? tree.roots : tree.bodies[parent].children).push_back(body);
    reached[body] = true;
  };
  const auto bodies = static_cast<int>(setup.bodies.size());
  for (int body = 0; body < bodies; ++body)
    if (setup.bodies[body].motion != MotionKind::free) attach(body, -1, -1);

  std::vector<int> edges = by_need(setup);
  for (int next_root = 0;;) {
    const auto grows = std::ranges::find_if(edges, [&](int joint) {
      return is_reached(setup.joints[joint].body_A) != is_reached(setup.joints[joint].body_B);
    });
    if (grows != edges.end()) {
      const JointSpecification& joint = setup.joints[*grows];
      if (is_reached(joint.body_A))
        attach(joint.body_B, joint.body_A, *grows);
      else
        attach(joint.body_A, joint.body_B, *grows);
      edges.erase(grows);
      continue;
    }
    while (next_root < bodies && reached[next_root]) ++next_root;
    if (next_root == bodies) break;
    attach(next_root, -1, -1);
  }
  tree.other_joints = std::move(edges);
  return tree;
}

}  // namespace copepod::body
