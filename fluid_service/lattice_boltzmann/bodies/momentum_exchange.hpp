#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lattice_boltzmann/bodies/boundary_links.hpp"
#include "lattice_boltzmann/bodies/fixed_point.hpp"

namespace copepod::fluid {

/// A population that a body's surface sends back, to be put in place before the bulk update.
template <class T>
struct ReflectedPopulation {
  std::int64_t location = 0;
  T value{};
};

template <class T>
struct ReflectedPopulations {
  /// By plane x, from the block's low corner, of the fluid cell.
  std::vector<std::vector<ReflectedPopulation<T>>> interior;
  std::vector<ReflectedPopulation<T>> border;  ///< to be applied after other ranks' populations have arrived

  explicit ReflectedPopulations(std::int64_t planes) : interior(static_cast<std::size_t>(planes)) {}
  void clear() {
    for (auto& plane : interior) plane.clear();
    border.clear();
  }
};

/// Moving bounce-back and momentum exchange of one body [paper, section 2.3; Yu et al. 2003; Ladd 1994]:
///   f_ᾱ(x_f) = f̃_α(x_f) − 6 w_α ρ_w e_α·u_w                    u_w = U + Ω × (x_f − X)
///   F = Σ_links e_α (f̃_α + f_ᾱ),   T = Σ_links (x_f − X) × e_α (f̃_α + f_ᾱ)
/// ρ_w is the density of the fluid cell. Every point of a link gives the same torque and the same e_α·u_w, so
/// x_f stands for the wall point. Populations are deviations f − w: the constant pressure of the fluid at
/// rest never enters, and bodies that touch feel no spurious force from links that are missing between them.
/// @param cells  of the body, on this rank
/// @param loads  sums (fixed_point.hpp) to which this rank's share is added
/// @throws SolverError if a population is not finite or absurdly large, naming the cell
template <class T>
void exchange_momentum(const T* populations, const PopulationLayout& layout, Placement placement,
                       const Domain& domain, const LatticeBody& body, std::span<const BoundaryCell> cells,
                       LoadSums& loads, ReflectedPopulations<T>& reflected);

}  // namespace copepod::fluid
