#pragma once

#include <array>

/// The D3Q19 velocity set [Qian, d'Humières, Lallemand 1992].
///
/// Direction 0 rests; opposite directions are neighbours: (1, 2), (3, 4), …, (17, 18), so that a collision
/// can go through pairs. Lattice units: cell size, step and reference density are 1, the speed of sound
/// squared is 1/3.
namespace copepod::fluid::d3q19 {

inline constexpr int directions = 19;

using Direction = std::array<int, 3>;

inline constexpr std::array<Direction, directions> e = {Direction{0, 0, 0}, {1, 0, 0},   {-1, 0, 0}, {0, 1, 0},
                                                        {0, -1, 0},         {0, 0, 1},   {0, 0, -1},              //
                                                        {1, 1, 0},          {-1, -1, 0}, {1, -1, 0}, {-1, 1, 0},  //
                                                        {1, 0, 1},          {-1, 0, -1}, {1, 0, -1}, {-1, 0, 1},  //
                                                        {0, 1, 1},          {0, -1, -1}, {0, 1, -1}, {0, -1, 1}};

/// The same as floating-point numbers, for products.
inline constexpr auto velocity = [] {
  std::array<std::array<double, 3>, directions> result{};
  for (std::size_t alpha = 0; alpha < directions; ++alpha)
    for (std::size_t axis = 0; axis < 3; ++axis) result[alpha][axis] = e[alpha][axis];
  return result;
}();

/// Index ᾱ of the direction −e_α.
constexpr int opposite(int alpha) { return alpha == 0 ? 0 : (alpha % 2 == 1 ? alpha + 1 : alpha - 1); }

inline constexpr auto weights = [] {
  std::array<double, directions> result{};
  for (int alpha = 0; alpha < directions; ++alpha)
    result[alpha] = alpha == 0 ? 1.0 / 3.0 : (alpha < 7 ? 1.0 / 18.0 : 1.0 / 36.0);
  return result;
}();

/// Weight w_α: 1/3 at rest, 1/18 along the axes, 1/36 along the diagonals.
constexpr double weight(int alpha) { return weights[alpha]; }

/// Index of the direction whose components are `direction`; −1 if the set has none.
constexpr int index_of(const Direction& direction) {
  for (int alpha = 0; alpha < directions; ++alpha)
    if (e[alpha] == direction) return alpha;
  return -1;
}

/// Index of e_α mirrored at a plane normal to `axis`.
constexpr int mirrored(int alpha, int axis) {
  Direction direction = e[alpha];
  direction[axis] = -direction[axis];
  return index_of(direction);
}

}  // namespace copepod::fluid::d3q19
