#pragma once

#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"

namespace copepod::body {

/// A row of consecutive bodies that no spring connects to bodies outside it.
///
/// Blocks are integrated one after the other through all stages of a step, so that the work on one stays in
/// the processor's cache whatever the number of bodies.
struct BodyBlock {
  Eigen::Index first = 0;
  Eigen::Index bodies = 0;
  std::vector<int> springs;  ///< indices of its springs, ascending
};

/// Cuts the bodies into blocks of about `preferred_bodies`, longer only where springs prevent a cut.
/// @param springs  with valid body indices
/// @return blocks in ascending order that cover all bodies and all springs once
std::vector<BodyBlock> independent_blocks(Eigen::Index bodies, const std::vector<SpringSpecification>& springs,
                                          Eigen::Index preferred_bodies);

}  // namespace copepod::body
