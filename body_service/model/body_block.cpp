#include "model/body_block.hpp"

#include <algorithm>
#include <cstddef>
#include <numeric>

namespace copepod::body {

namespace {

bool joins_centres(const SpringSpecification& spring) {
  return spring.anchor_A_m.isZero(0.0) && spring.anchor_B_m.isZero(0.0);
}

bool joins_centres(const ActuatorSpecification& actuator) {
  return actuator.kind == ActuatorKind::pair_force && actuator.anchor_A_m.isZero(0.0) &&
         actuator.anchor_B_m.isZero(0.0);
}

void find_lines(const BodySetup& setup, BodyBlock& block) {
  const auto first = static_cast<int>(block.first);
  const auto ends = [first](const auto& element) { return std::array{element.body_A - first, element.body_B - first}; };
  const auto collect = [&](const auto& elements, const std::vector<int>& indices) {
    for (const int index : indices)
      if (joins_centres(elements[index])) block.lines.push_back(ends(elements[index]));
  };
  collect(setup.springs, block.springs);
  collect(setup.actuators, block.actuators);
  std::ranges::sort(block.lines);
  block.lines.erase(std::unique(block.lines.begin(), block.lines.end()), block.lines.end());
  const auto number = [&](const auto& elements, const std::vector<int>& indices, std::vector<int>& lines) {
    for (const int index : indices) {
      const auto line = std::ranges::lower_bound(block.lines, ends(elements[index]));
      lines.push_back(joins_centres(elements[index]) ? static_cast<int>(line - block.lines.begin()) : -1);
    }
  };
  number(setup.springs, block.springs, block.spring_lines);
  number(setup.actuators, block.actuators, block.actuator_lines);
}

}  // namespace

std::vector<BodyBlock> independent_blocks(const BodySetup& setup, Eigen::Index preferred_bodies) {
  const auto bodies = static_cast<int>(setup.bodies.size());
  // reach[i]: the last body that is joined to body i or, further down, to one before it.
  std::vector<int> reach(setup.bodies.size());
  std::iota(reach.begin(), reach.end(), 0);
  const auto join = [&reach](int one, int other) {
    const auto [low, high] = std::minmax(one, other);
    reach[low] = std::max(reach[low], high);
  };
  for (const auto& spring : setup.springs) join(spring.body_A, spring.body_B);
  for (const auto& bend : setup.bends) {
    join(bend.body_A, bend.body_B);
    join(bend.body_B, bend.body_C);
  }
  for (const auto& joint : setup.joints)
    if (joint.body_B >= 0) join(joint.body_A, joint.body_B);
  for (const auto& actuator : setup.actuators)
    if (actuator.kind == ActuatorKind::pair_force) join(actuator.body_A, actuator.body_B);

  std::vector<BodyBlock> blocks;
  std::vector<std::size_t> block_of(reach.size());
  int first = 0;
  int last_reached = -1;
  for (int i = 0; i < bodies; ++i) {
    last_reached = std::max(last_reached, reach[i]);
    block_of[i] = blocks.size();
    const bool closed = last_reached == i;
    if ((closed && i + 1 - first >= preferred_bodies) || i + 1 == bodies) {
      blocks.push_back({first, i + 1 - first});
      blocks.back().of_free_spheres =
          std::all_of(setup.bodies.begin() + first, setup.bodies.begin() + i + 1, [](const BodySpecification& body) {
            return body.shape.kind == ShapeKind::sphere && body.inertia_kg_m2.empty() &&
                   body.motion == MotionKind::free;
          });
      first = i + 1;
    }
  }
  const auto distribute = [&](const auto& elements, std::vector<int> BodyBlock::*indices) {
    for (std::size_t i = 0; i < elements.size(); ++i)
      (blocks[block_of[elements[i].body_A]].*indices).push_back(static_cast<int>(i));
  };
  distribute(setup.springs, &BodyBlock::springs);
  distribute(setup.bends, &BodyBlock::bends);
  distribute(setup.actuators, &BodyBlock::actuators);
  for (BodyBlock& block : blocks) find_lines(setup, block);
  return blocks;
}

}  // namespace copepod::body
