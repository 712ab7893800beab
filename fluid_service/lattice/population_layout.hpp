#pragma once

#include <cstdint>

#include "lattice/d3q19.hpp"
#include "partition/box.hpp"

namespace copepod::fluid {

/// Where the post-collision populations are stored between two steps (in-place "AA" streaming, Bailey et al.
/// 2009).
///
/// One array of 19 slots per cell serves both the old and the new populations. Steps alternate between
///   home     -> streamed: read slot ᾱ of x − e_α, collide, write slot α of x + e_α;
///   streamed -> home:     read slot α of x,       collide, write slot ᾱ of x.
/// In both, the slots that a cell reads are those that it writes, and no other cell touches them.
enum class Placement {
  home,      ///< f̃_α(x) is in slot ᾱ of x
  streamed,  ///< f̃_α(x) is in slot α of x + e_α
};

constexpr Placement other(Placement placement) {
  return placement == Placement::home ? Placement::streamed : Placement::home;
}

/// Addresses of the slots of one block: populations (q = 19, x, y, z), one ghost layer, z fastest.
///
/// Interior rows start on a cache line. The stride between the 19 arrays is skewed so that a cell's 19 slots
/// fall into different cache sets.
class PopulationLayout {
 public:
  explicit PopulationLayout(const Box& block, int value_bytes)
      : block_(block),
        lead_(64 / value_bytes),
        pitch_(round_up(lead_ + block.extent(2) + 1, lead_)),
        plane_(pitch_ * (block.extent(1) + 2)),
        slot_(round_up(plane_ * (block.extent(0) + 2), 4096 / value_bytes) + skew_lines * lead_) {
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      location_[static_cast<int>(Placement::home)][alpha] = slot(d3q19::opposite(alpha));
      location_[static_cast<int>(Placement::streamed)][alpha] = slot(alpha) + neighbour(alpha);
    }
  }

  [[nodiscard]] const Box& block() const { return block_; }
  /// Index of cell (x, y, z), counted from the block's low corner; −1 and extent are ghosts.
  [[nodiscard]] constexpr std::int64_t cell(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return (x + 1) * plane_ + (y + 1) * pitch_ + z + lead_;
  }
  [[nodiscard]] constexpr std::int64_t cell(const Cell& global) const {
    return cell(global[0] - block_.low[0], global[1] - block_.low[1], global[2] - block_.low[2]);
  }
  /// Distance from a cell to its neighbour in direction α.
  [[nodiscard]] constexpr std::int64_t neighbour(int alpha) const {
    return d3q19::e[alpha][0] * plane_ + d3q19::e[alpha][1] * pitch_ + d3q19::e[alpha][2];
  }
  [[nodiscard]] constexpr std::int64_t slot(int alpha) const { return alpha * slot_; }
  /// Where f̃_α of the cell with index `cell` is stored.
  [[nodiscard]] constexpr std::int64_t location(std::int64_t cell, int alpha, Placement placement) const {
    return location_[static_cast<int>(placement)][alpha] + cell;
  }
  [[nodiscard]] constexpr std::int64_t values() const { return d3q19::directions * slot_; }
  [[nodiscard]] constexpr std::int64_t cells() const { return plane_ * (block_.extent(0) + 2); }
  [[nodiscard]] constexpr std::int64_t row_pitch() const { return pitch_; }

 private:
  static constexpr std::int64_t skew_lines = 3;
  static constexpr std::int64_t round_up(std::int64_t value, std::int64_t multiple) {
    return (value + multiple - 1) / multiple * multiple;
  }

  Box block_;
  std::int64_t lead_;   ///< values before the first interior cell of a row; its last one is the ghost
  std::int64_t pitch_;  ///< values per row
  std::int64_t plane_;  ///< values per plane of constant x
  std::int64_t slot_;   ///< values between two slots of a cell
  std::int64_t location_[2][d3q19::directions] = {};  ///< of f̃_α relative to its cell, by placement
};

}  // namespace copepod::fluid
