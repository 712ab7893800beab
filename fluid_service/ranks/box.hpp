#pragma once

#include <array>
#include <cstdint>

namespace copepod::fluid {

using Cell = std::array<std::int64_t, 3>;  ///< global cell indices x, y, z

/// Half-open box of cells [low, high).
struct Box {
  Cell low{};
  Cell high{};

  [[nodiscard]] constexpr std::int64_t extent(int axis) const { return high[axis] - low[axis]; }
  [[nodiscard]] constexpr std::int64_t volume() const { return extent(0) * extent(1) * extent(2); }
  [[nodiscard]] constexpr bool contains_along(int axis, std::int64_t index) const {
    return index >= low[axis] && index < high[axis];
  }
  [[nodiscard]] constexpr bool contains(const Cell& cell) const {
    return contains_along(0, cell[0]) && contains_along(1, cell[1]) && contains_along(2, cell[2]);
  }
  bool operator==(const Box&) const = default;
};

}  // namespace copepod::fluid
