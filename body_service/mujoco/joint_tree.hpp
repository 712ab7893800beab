#pragma once

#include <vector>

#include "contract/body_setup.hpp"

namespace copepod::body {

/// The bodies of a case as trees that grow from the world along its joints.
struct JointTree {
  struct Node {
    int parent = -1;  ///< body; −1: the world
    int joint = -1;   ///< that connects them; −1: none, the body has its own freedom
    std::vector<int> children{};
  };
  std::vector<Node> bodies;
  std::vector<int> roots;         ///< bodies that hang on the world
  std::vector<int> other_joints;  ///< those that close loops
};

/// Joints that MuJoCo can keep only as edges of a tree are edges wherever possible: sliders, rods, and those that have
/// a spring or are driven.
JointTree joint_tree_of(const BodySetup& setup);

/// Whether an actuator gives the joint's motion.
bool is_driven(const BodySetup& setup, int joint);

}  // namespace copepod::body
