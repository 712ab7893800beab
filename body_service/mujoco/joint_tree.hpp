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

/// Joints that MuJoCo can keep only as edges are edges wherever possible.
JointTree joint_tree_of(const BodySetup& setup);

/// Whether MuJoCo cannot keep the joint but as an edge: a slider, a rod, one that has a spring or is driven.
bool must_be_edge(const BodySetup& setup, int joint);

/// Whether an actuator gives the joint's motion.
bool is_driven(const BodySetup& setup, int joint);

}  // namespace copepod::body
