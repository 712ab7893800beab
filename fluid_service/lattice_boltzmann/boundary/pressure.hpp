#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

// Open faces at a given pressure: the flow continues beyond them as it is, and the density so that it is the given one
// at the face.

namespace copepod::fluid {

/// The population that enters through a face of given density:
///   f_ᾱ(x_f) = f̃_ᾱ(x_f + e_t) + 2 w_α (ρ_w − ρ(x_f)),   e_t = e_α − n
/// x_f + e_t is the cell beside the ghost cell x_f + e_α, across the face with the normal n. Populations beyond the
/// face are those before it but for the density, 2 ρ_w − ρ: a flow that does not change along n is a solution of the
/// lattice, whatever its profile, collision and viscosity.
/// @param direction       ᾱ, into the fluid
/// @param beside          f̃_ᾱ(x_f + e_t) − w_α
/// @param excess_density  of the face, ρ_w − 1
/// @param of_cell         the same of x_f
inline double continued_flow(int direction, double beside, double excess_density, double of_cell) {
  return beside + 2.0 * d3q19::weight(direction) * (excess_density - of_cell);
}

/// The open faces of one block.
class PressureFaces {
 public:
  /// @throws CaseError if the block is too thin
  PressureFaces(const Domain& domain, const PopulationLayout& layout) : layout_(layout) {
    for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.kind != GhostSource::Kind::pressure) return;
      Link& link = links_.emplace_back(Link{layout.site(source.cell), direction, source.excess_density, {}, 0});
      Cell beside = ghost;       // x_f + e_t
      Cell inner = source.cell;  // x_f − n, which f̃_ᾱ of the cell beside enters, also from another rank
      int open_faces = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (domain.image(axis, ghost[axis])) continue;
        beside[axis] = source.cell[axis];
        inner[axis] += d3q19::e[direction][axis];
        ++open_faces;
      }
      if (open_faces > 1 || !domain.box().contains(inner)) return;
      if (!layout.block().contains(inner))
        throw CaseError("a rank has one layer of cells beside an open face (it needs two). Use fewer ranks.");
      link.beside = layout.cell(beside);
      for (const Placement placement : {Placement::home, Placement::streamed})
        link.enters[static_cast<std::size_t>(placement)] = layout.entry(layout.site(inner), direction, placement);
    });
  }

  [[nodiscard]] bool empty() const { return links_.empty(); }

  /// f̃_α lies where f_ᾱ will be read, so all of a cell's are computed before one is replaced.
  /// @param populations  with those of other ranks
  /// @param is_solid     whether a body covers a cell of the layout
  template <class T, class IsSolid>
  void apply(T* populations, Placement placement, const IsSolid& is_solid) {
    entering_.clear();
    for (const auto& [cell, direction, excess_density, enters, beside] : links_) {
      const bool continues = beside != 0 && !is_solid(beside);
      const double known = populations[continues ? enters[static_cast<std::size_t>(placement)]
                                                 : layout_.location(cell, direction, placement)];
      const double of_cell = moments(layout_.gather(populations, cell, placement)).excess_density;
      entering_.push_back(continued_flow(direction, known, excess_density, of_cell));
    }
    for (std::size_t i = 0; i < links_.size(); ++i)
      populations[layout_.entry(links_[i].cell, links_[i].direction, placement)] = static_cast<T>(entering_[i]);
  }

 private:
  struct Link {
    Site cell;          ///< x_f
    int direction = 0;  ///< ᾱ
    double excess_density = 0.0;
    std::array<std::int64_t, 2> enters{};  ///< where f̃_ᾱ(x_f + e_t) is, by placement
    std::int64_t beside = 0;               ///< index of x_f + e_t; 0: unknown, x_f takes its place
  };

  const PopulationLayout& layout_;
  std::vector<Link> links_;
  std::vector<double> entering_;
};

}  // namespace copepod::fluid
