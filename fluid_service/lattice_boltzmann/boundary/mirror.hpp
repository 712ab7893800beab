#pragma once

#include <array>
#include <cstdint>

// Mirrors: symmetry planes and free-slip faces. The plane lies on cell faces, and beyond it is the fluid's
// own mirror image, so that a population comes back in its mirrored direction (d3q19::mirrored) to its own
// plane of cells: the normal momentum is reversed, the tangential one kept. They cost no time
// (PopulationLayout).

namespace copepod::fluid {

/// Index of the cell whose image is `index`, at most one period outside [0, cells).
constexpr std::int64_t reflected(std::int64_t index, std::int64_t cells) {
  return index < 0 ? -1 - index : 2 * cells - 1 - index;
}

/// Factors that turn loads on the visible part of a body into loads on the whole of it.
struct WholeBody {
  std::array<double, 3> force = {1.0, 1.0, 1.0};
  std::array<double, 3> torque = {1.0, 1.0, 1.0};

  /// A plane normal to `plane` cuts the body: what its symmetry forbids is zero (force normal to it, torque
  /// along it), the rest counts twice.
  constexpr void cut(std::size_t plane) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      force[axis] *= axis == plane ? 0.0 : 2.0;
      torque[axis] *= axis == plane ? 2.0 : 0.0;
    }
  }
};

}  // namespace copepod::fluid
