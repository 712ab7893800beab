#pragma once

#include <Eigen/Core>

#include "lattice_boltzmann/lattice/population_layout.hpp"

namespace copepod::fluid {

/// Excess density δρ = Σ (f̃_α − w_α) and momentum Σ f̃_α e_α of one cell, lattice units, in double whatever T
/// is.
struct CellMoments {
  double excess_density = 0.0;
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();
};

template <class T>
double excess_density_of_cell(const T* populations, const PopulationLayout& layout, const Site& cell,
                              Placement placement) {
  auto sum = static_cast<double>(populations[layout.location(cell, 0, placement)]);
  // Pairs first: the sum is then the same for a cell and its mirror image.
  double axes = 0.0;
  double diagonals[3] = {0.0, 0.0, 0.0};
  for (int alpha = 1; alpha < d3q19::directions; alpha += 2) {
    const double pair = static_cast<double>(populations[layout.location(cell, alpha, placement)]) +
                        static_cast<double>(populations[layout.location(cell, alpha + 1, placement)]);
    if (alpha < 7)
      axes += pair;
    else
      diagonals[(alpha - 7) / 4] += pair;
  }
  sum += axes;
  return sum + (diagonals[0] + diagonals[1] + diagonals[2]);
}

template <class T>
CellMoments moments_of_cell(const T* populations, const PopulationLayout& layout, const Site& cell,
                            Placement placement) {
  CellMoments result;
  result.excess_density = excess_density_of_cell(populations, layout, cell, placement);
  for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
    const auto f = static_cast<double>(populations[layout.location(cell, alpha, placement)]);
    for (int axis = 0; axis < 3; ++axis) result.momentum[axis] += d3q19::e[alpha][axis] * f;
  }
  return result;
}

}  // namespace copepod::fluid
