#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "lattice_boltzmann/lattice/d3q19.hpp"
#include "ranks/block_partition.hpp"

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

/// Faces of the block that a cell lies on, as bits: x low, x high, y low, …
using Faces = unsigned;

constexpr Faces face_bit(int axis, bool high) { return 1U << (2 * axis + (high ? 1 : 0)); }

/// A cell of the block: index within one slot's array, and its faces.
struct Site {
  std::int64_t index = 0;
  Faces faces = 0;
};

/// The cell, relative to the one that is entered, and the direction whose f̃ enters. Inside: x − e_α and α.
struct Origin {
  Cell offset{};
  int direction = 0;
};

/// Origin of f_α for a cell on the given faces. It must be one-to-one: no f̃ enters two cells.
using OriginRule = std::function<Origin(Faces faces, int direction)>;

constexpr Origin straight(int direction) {
  const auto& e = d3q19::e[direction];
  return {{-e[0], -e[1], -e[2]}, direction};
}

/// Addresses of the slots of one block: populations (q = 19, x, y, z), one ghost layer, z fastest.
///
/// Cells on faces may draw populations from elsewhere than the neighbour behind them: from themselves at a
/// wall, from the other end of a period. Since in-place streaming stores f̃_α where f_α will be read, such a
/// face costs nothing: the slots of the cells beside it are merely others.
///
/// Interior rows start on a cache line. The stride between the 19 arrays is skewed so that a cell's 19 slots
/// fall into different cache sets.
class PopulationLayout {
 public:
  /// @param origin  where populations enter cells on the block's faces from; by default from ghost cells
  PopulationLayout(
      const Box& block, int value_bytes,
      const OriginRule& origin = [](Faces, int direction) { return straight(direction); });

  [[nodiscard]] const Box& block() const { return block_; }
  /// Index of cell (x, y, z), counted from the block's low corner; −1 and extent are ghosts.
  [[nodiscard]] constexpr std::int64_t cell(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return (x + 1) * plane_ + (y + 1) * pitch_ + z + lead_;
  }
  [[nodiscard]] constexpr std::int64_t cell(const Cell& global) const {
    return cell(global[0] - block_.low[0], global[1] - block_.low[1], global[2] - block_.low[2]);
  }
  /// The same with the cell's faces; no ghosts.
  [[nodiscard]] constexpr Site site(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return {cell(x, y, z), on_faces(0, x) | on_faces(1, y) | on_faces(2, z)};
  }
  [[nodiscard]] constexpr Site site(const Cell& global) const {
    return site(global[0] - block_.low[0], global[1] - block_.low[1], global[2] - block_.low[2]);
  }
  /// A cell of row (x, y), treated like one between the row's ends.
  [[nodiscard]] constexpr Site in_row(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return {cell(x, y, z), on_faces(0, x) | on_faces(1, y)};
  }
  /// Distance from a cell to its neighbour in direction α.
  [[nodiscard]] constexpr std::int64_t neighbour(int alpha) const {
    return d3q19::e[alpha][0] * plane_ + d3q19::e[alpha][1] * pitch_ + d3q19::e[alpha][2];
  }
  [[nodiscard]] constexpr std::int64_t slot(int alpha) const { return alpha * slot_; }

  /// Where f̃_α of a cell on `faces` is stored, relative to the cell's index, for all α.
  using Locations = std::array<std::int64_t, d3q19::directions>;
  [[nodiscard]] const Locations& locations(Faces faces, Placement placement) const {
    return placement == Placement::home ? home_ : streamed_[faces];
  }
  [[nodiscard]] std::int64_t location(const Site& site, int alpha, Placement placement) const {
    return site.index + locations(site.faces, placement)[alpha];
  }
  /// Where f_α, which enters the cell, is read in the next step: where that step will store f̃_ᾱ.
  [[nodiscard]] std::int64_t entry(const Site& site, int alpha, Placement placement) const {
    return location(site, d3q19::opposite(alpha), other(placement));
  }
  /// All f̃_α of a cell, in double whatever the solver stores.
  template <class T>
  [[nodiscard]] std::array<double, d3q19::directions> gather(const T* populations, const Site& site,
                                                             Placement placement) const {
    const Locations& from = locations(site.faces, placement);
    const auto each = [&]<std::size_t... alpha>(std::index_sequence<alpha...>) __attribute__((always_inline)) {
      return std::array{static_cast<double>(populations[site.index + from[alpha]])...};
    };
    return each(std::make_index_sequence<d3q19::directions>{});
  }

  /// A slot of a row's end cell, relative to its index, and where the row's other cells would have it.
  struct Detour {
    std::int64_t slot = 0;
    std::int64_t in_row = 0;
  };
  /// For an end cell on `faces`, in the streamed placement.
  [[nodiscard]] std::span<const Detour> detours(Faces faces) const { return detours_[faces]; }

  [[nodiscard]] constexpr std::int64_t values() const { return d3q19::directions * slot_; }
  [[nodiscard]] constexpr std::int64_t cells() const { return plane_ * (block_.extent(0) + 2); }
  [[nodiscard]] constexpr std::int64_t row_pitch() const { return pitch_; }

 private:
  static constexpr std::size_t face_sets = 64;
  static constexpr std::int64_t skew_lines = 3;

  [[nodiscard]] constexpr Faces on_faces(int axis, std::int64_t local) const {
    return (local == 0 ? face_bit(axis, false) : 0U) | (local == block_.extent(axis) - 1 ? face_bit(axis, true) : 0U);
  }

  Box block_;
  std::int64_t lead_;   ///< values before the first interior cell of a row; its last one is the ghost
  std::int64_t pitch_;  ///< values per row
  std::int64_t plane_;  ///< values per plane of constant x
  std::int64_t slot_;   ///< values between two slots of a cell
  Locations home_{};
  std::array<Locations, face_sets> streamed_{};
  std::array<std::vector<Detour>, face_sets> detours_;
};

}  // namespace copepod::fluid
