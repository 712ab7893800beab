#pragma once

#include <cmath>
#include <cstdint>

// Periodic faces: what leaves through one enters through the other. They cost no time: with streaming in
// place a population is stored where it enters, at the other end of the domain (PopulationLayout), or travels
// in a message to the rank that is there (HaloExchange).

namespace copepod::fluid {

/// Index in [0, cells) of the cell that `index` stands for.
constexpr std::int64_t wrapped(std::int64_t index, std::int64_t cells) { return ((index % cells) + cells) % cells; }

/// r − L round(r / L): one component of a distance, to the nearest image.
inline double to_nearest_image(double r, double length) {
  if (std::abs(r) < 0.49 * length) return r;  // without a division
  return r - length * std::round(r / length);
}

}  // namespace copepod::fluid
