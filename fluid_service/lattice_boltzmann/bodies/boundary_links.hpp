#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lattice_boltzmann/bodies/body_map.hpp"

namespace copepod::fluid {

/// A fluid cell next to a body, with its links into that body.
struct BoundaryCell {
  Site site;
  Cell position{};               ///< domain cell, of this rank
  std::uint32_t directions = 0;  ///< bit α set: x_f + e_α is covered by the body
  bool border = false;           ///< touches another rank's populations (HaloExchange::interior)
};

/// Links of each body: lists of boundary cells, kept up to date around cells that change hands.
class BoundaryLinks {
 public:
  BoundaryLinks(const BodyMap& map, const PopulationLayout& layout, const Box& interior);

  /// Brings the lists in line with the map after an update of it: only cells next to a changed one can
  /// differ.
  void update();
  /// Sorted by cell.
  [[nodiscard]] std::span<const BoundaryCell> of_body(std::size_t body) const { return cells_[body]; }

 private:
  void look_at(const Cell& cell, std::int32_t changed_body);
  void set(std::int32_t body, const Cell& cell, std::uint32_t directions);

  const BodyMap& map_;
  const PopulationLayout& layout_;
  Box interior_;
  std::vector<std::vector<BoundaryCell>> cells_;
};

}  // namespace copepod::fluid
