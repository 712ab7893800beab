#pragma once

#include <cstdint>
#include <vector>

#include "ranks/box.hpp"

namespace copepod::fluid {

/// One rank's share of the output fields, SI units; arrays in order (x, y, z), z fastest.
struct FieldBlock {
  Box box;                                ///< cells of the computed domain that this rank owns
  std::vector<double> density_kg_per_m3;  ///< shape (x, y, z)
  std::vector<double> velocity_m_per_s;   ///< shape (x, y, z, 3)
  std::vector<std::int32_t> body;         ///< shape (x, y, z); 0 fluid, else 1 + body index
};

}  // namespace copepod::fluid
