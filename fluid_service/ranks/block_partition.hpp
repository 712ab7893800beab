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

/// Calls visit(cell) for every cell of `box`, z fastest, and after_plane() after each plane of constant x.
template <class Visit, class AfterPlane = decltype([] {})>
void for_each_cell(const Box& box, const Visit& visit, const AfterPlane& after_plane = {}) {
  for (std::int64_t x = box.low[0]; x < box.high[0]; ++x) {
    for (std::int64_t y = box.low[1]; y < box.high[1]; ++y)
      for (std::int64_t z = box.low[2]; z < box.high[2]; ++z) visit(Cell{x, y, z});
    after_plane();
  }
}

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

/// Cuts a box of cells into one block per rank: arithmetic only, no MPI.
///
/// Among all factorisations ranks = px · py · pz the one with the cheapest halo is taken; cuts normal to x
/// cost least because rows along z stay long and contiguous. Rank 0, and those beside it in one layer of blocks, have
/// fewer cells by as many as take the time in which it deals with all bodies (docs/decisions/nearby_bodies.md).
class BlockPartition {
 public:
  /// @param cells   computed domain, each extent > 0
  /// @param ranks   > 0
  /// @param bodies  in the domain
  /// @throws CaseError if a rank would be empty whatever the factorisation
  BlockPartition(const Cell& cells, int ranks, std::size_t bodies = 0);

  [[nodiscard]] const std::array<int, 3>& grid() const { return grid_; }  ///< blocks along x, y, z
  [[nodiscard]] Box block(int rank) const;                                ///< never empty
  [[nodiscard]] int place(int axis, std::int64_t index) const;  ///< of the block with that cell, along an axis
  [[nodiscard]] int owner(const Cell& cell) const;              ///< rank whose block holds `cell`
  [[nodiscard]] const Cell& cells() const { return cells_; }
  [[nodiscard]] int ranks() const { return grid_[0] * grid_[1] * grid_[2]; }

 private:
  Cell cells_;
  std::array<int, 3> grid_{};
  Cell less_{};  ///< cells along each axis by which the first block is shorter than the others
};

}  // namespace copepod::fluid
