#pragma once

#include "ranks/box.hpp"

namespace copepod::fluid {

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
