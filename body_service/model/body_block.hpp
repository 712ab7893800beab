#pragma once

#include <array>
#include <tuple>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "model/motion_state.hpp"
#include "model/vector_loops.hpp"

namespace copepod::body {

/// A row of consecutive bodies that neither springs, bends nor pair forces connect to bodies outside it.
///
/// Blocks are integrated one after the other through all stages of a step, so that the work on one stays in
/// the processor's cache whatever the number of bodies.
struct BodyBlock {
  Eigen::Index first = 0;
  Eigen::Index bodies = 0;
  std::vector<int> springs{};    ///< indices of its springs, ascending
  std::vector<int> bends{};      ///< of its bends
  std::vector<int> actuators{};  ///< of its actuators
  /// Bodies, counted from `first`, whose centres springs or pair forces join, each two once.
  std::vector<std::array<int, 2>> lines{};
  std::vector<int> spring_lines{};    ///< the line of each of its springs; −1: it has anchors elsewhere
  std::vector<int> actuator_lines{};  ///< of each of its actuators; −1: it is not a force between two centres
  bool of_free_spheres = false;       ///< whether nothing but loads and inertia determines how its bodies move and turn
};

/// Copies the columns of a block to the front of a work array.
void split(const auto& of_all, const BodyBlock& block, auto& of_block) {
  std::apply([&](auto... to) { split(block.bodies, of_all.col(block.first).data(), to...); }, components(of_block));
}

/// Copies the front of a work array to the columns of a block.
void join(const auto& of_block, const BodyBlock& block, auto& of_all) {
  join(block.bodies, components(of_block), of_all.col(block.first).data());
}

/// Cuts the bodies into blocks of about `preferred_bodies`, longer only where what joins bodies prevents a cut.
/// @param setup  with valid body indices
/// @return blocks in ascending order that cover all bodies and all that joins them once
std::vector<BodyBlock> independent_blocks(const BodySetup& setup, Eigen::Index preferred_bodies);

}  // namespace copepod::body
