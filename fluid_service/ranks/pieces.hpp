#pragma once

#include "ranks/box.hpp"

namespace copepod::fluid {

/// Calls visit(piece) for boxes that together are `box`, in the order of their cells (x, y, z), z fastest: an
/// axis is cut only where those before it are one cell wide.
/// @param most_cells  of a piece, at least 1
template <class Visit>
void for_each_piece(const Box& box, std::int64_t most_cells, const Visit& visit) {
  if (box.volume() <= most_cells) {
    if (box.volume() > 0) visit(box);
    return;
  }
  std::size_t axis = 0;
  while (box.high[axis] - box.low[axis] == 1) ++axis;
  Box first = box;
  Box second = box;
  first.high[axis] = second.low[axis] = box.low[axis] + (box.high[axis] - box.low[axis]) / 2;
  for_each_piece(first, most_cells, visit);
  for_each_piece(second, most_cells, visit);
}

}  // namespace copepod::fluid
