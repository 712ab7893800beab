#include "model/body_block.hpp"

#include <algorithm>
#include <cstddef>

namespace copepod::body {

std::vector<BodyBlock> independent_blocks(Eigen::Index bodies, const std::vector<SpringSpecification>& springs,
                                          Eigen::Index preferred_bodies) {
  // reach[i]: the last body that a spring connects to body i or, further down, to one before it.
  std::vector<Eigen::Index> reach(static_cast<std::size_t>(bodies));
  for (Eigen::Index i = 0; i < bodies; ++i) reach[i] = i;
  for (const auto& spring : springs) {
    const auto [low, high] = std::minmax(spring.body_A, spring.body_B);
    reach[low] = std::max(reach[low], static_cast<Eigen::Index>(high));
  }

  std::vector<BodyBlock> blocks;
  std::vector<std::size_t> block_of(reach.size());
  Eigen::Index first = 0;
  Eigen::Index last_reached = -1;
  for (Eigen::Index i = 0; i < bodies; ++i) {
    last_reached = std::max(last_reached, reach[i]);
    block_of[i] = blocks.size();
    const bool closed = last_reached == i;
    if ((closed && i + 1 - first >= preferred_bodies) || i + 1 == bodies) {
      blocks.push_back({first, i + 1 - first, {}});
      first = i + 1;
    }
  }
  for (std::size_t s = 0; s < springs.size(); ++s) {
    blocks[block_of[springs[s].body_A]].springs.push_back(static_cast<int>(s));
  }
  return blocks;
}

}  // namespace copepod::body
