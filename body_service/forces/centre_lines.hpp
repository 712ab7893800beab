#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "model/body_block.hpp"
#include "model/motion_state.hpp"
#include "model/vector_loops.hpp"

namespace copepod::body {

/// Lengths and directions of the lines of a block (BodyBlock::lines), measured once per stage for springs and drive.
struct CentreLines {
  /// @param position_m  column 0 is body block.first
  void measure(const BodyBlock& block, const BlockVectors& position_m) {
    const auto lines = static_cast<Eigen::Index>(block.lines.size());
    if (length_m.size() < lines) {
      length_m.resize(lines);
      direction.resize(3, lines);
    }
    if (lines == 0) return;
    const auto [x, y, z] = components(direction);
    const auto p = components(position_m);
    for (Eigen::Index i = 0; i < lines; ++i) {
      const auto [A, B] = block.lines[static_cast<std::size_t>(i)];
      x[i] = p[0][B] - p[0][A];
      y[i] = p[1][B] - p[1][A];
      z[i] = p[2][B] - p[2][A];
    }
    normalise_vectors(block.lines.size(), {x, y, z}, length_m.data());
  }

  Eigen::VectorXd length_m;  ///< 0: the ends coincide, the direction is undefined
  BlockVectors direction;    ///< from the first end to the second
};

/// Adds the forces that pull the ends of a line together.
/// @param e        unit vector from the first end to the second
/// @param force_N  components of the sums
inline void pull_together(const std::array<int, 2>& ends, double tension_N, const std::array<double, 3>& e,
                          const std::array<double*, 3>& force_N) {
  const std::array pull_N{tension_N * e[0], tension_N * e[1], tension_N * e[2]};
  for (std::size_t k = 0; k < 3; ++k) {
    force_N[k][ends[0]] += pull_N[k];
    force_N[k][ends[1]] -= pull_N[k];
  }
}

}  // namespace copepod::body
