#pragma once

#include <cstdint>

#include "lattice_boltzmann/bodies/lattice_body.hpp"

namespace copepod::fluid {

/// Half-open range of cells [low, high) along z, in cells counted without wrapping; empty if low ≥ high.
struct RowInterval {
  std::int64_t low = 0;
  std::int64_t high = 0;

  [[nodiscard]] bool empty() const { return low >= high; }
  bool operator==(const RowInterval&) const = default;
};

/// Cells of row (x, y) whose centres lie inside a body: bodies are convex, so they are one interval.
///
/// A sphere cuts the row's line at z = Z ± √(R² − dx² − dy²). A capsule is the convex hull of its two end
/// spheres: the interval reaches from the lowest to the highest point of the line in the two spheres and in
/// the cylinder between.
RowInterval covered_cells(const LatticeBody& body, std::int64_t x, std::int64_t y);

}  // namespace copepod::fluid
