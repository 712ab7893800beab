#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

// Open faces at a given pressure: the flow continues beyond them as it is, and the density so that it is the given one
// at the face.

namespace copepod::fluid {

/// The population that enters through a face of given density where the flow beyond it is known:
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

/// Anti-bounce-back, where it is not known [Ginzburg, Verhaeghe, d'Humières 2008]:
///   f_ᾱ(x_f) = −f̃_α(x_f) + 2 w_α ρ_w (1 + 9/2 (e·u)² − 3/2 u²)
/// as a deviation from w_ᾱ. It neglects shear.
/// @param direction       ᾱ, into the fluid
/// @param leaving         f̃_α(x_f) − w_α
/// @param excess_density  of the face, ρ_w − 1
/// @param u               at the face
inline double anti_bounce_back(int direction, double leaving, double excess_density, const Eigen::Vector3d& u) {
  const auto& e = d3q19::e[direction];
  const double eu = e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
  const double uu = u.squaredNorm();
  return -leaving +
         2.0 * d3q19::weight(direction) * (excess_density + (1.0 + excess_density) * (4.5 * eu * eu - 1.5 * uu));
}

/// The open faces of one block.
class PressureFaces {
 public:
  /// @param body_force_lu  on the fluid, per volume
  /// @throws CaseError if the block is too thin
  PressureFaces(const Domain& domain, const PopulationLayout& layout, const Eigen::Vector3d& body_force_lu)
      : layout_(layout), half_force_(0.5 * body_force_lu) {
    for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.kind != GhostSource::Kind::pressure) return;
      links_.push_back({layout.site(source.cell), direction, source.excess_density, {}, 0});
      Cell beside = ghost;       // x_f + e_t
      Cell inner = source.cell;  // x_f − n, which f̃_ᾱ of the cell beside enters, also from another rank
      int open_faces = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (domain.image(axis, ghost[axis])) continue;
        beside[axis] = source.cell[axis];
        inner[axis] += d3q19::e[direction][axis];
        ++open_faces;
      }
      // Beyond two faces the flow is not known, nor is it where the domain is one cell wide.
      if (open_faces > 1 || !domain.box().contains(inner)) return;
      if (!layout.block().contains(inner))
        throw CaseError("a rank has one layer of cells beside an open face (it needs two). Use fewer ranks.");
      links_.back().beside = layout.cell(beside);
      for (const Placement placement : {Placement::home, Placement::streamed})
        links_.back().enters[static_cast<std::size_t>(placement)] =
            layout.entry(layout.site(inner), direction, placement);
    });
  }

  [[nodiscard]] bool empty() const { return links_.empty(); }

  /// The velocity at the face is that of the fluid cell, u = (Σ f̃ e − F/2) / ρ: a collision adds half of the
  /// force F that belongs to the next half step [Guo, Zheng, Shi 2002]. f̃_α lies where f_ᾱ will be read, so
  /// all of a cell's are computed before one is replaced.
  /// @param populations  with those of other ranks
  /// @param is_solid     whether a body covers a cell of the layout
  template <class T, class IsSolid>
  void apply(T* populations, Placement placement, const IsSolid& is_solid) {
    entering_.clear();
    for (const Link& link : links_) {
      const Moments<double> m = moments(layout_.gather(populations, link.cell, placement));
      if (link.beside != 0 && !is_solid(link.beside)) {
        const double beside = populations[link.enters[static_cast<std::size_t>(placement)]];
        entering_.push_back(continued_flow(link.direction, beside, link.excess_density, m.excess_density));
        continue;
      }
      const Eigen::Vector3d u = (m.momentum_vector() - half_force_) * (1.0 / (1.0 + m.excess_density));
      const double leaving = populations[layout_.location(link.cell, d3q19::opposite(link.direction), placement)];
      entering_.push_back(anti_bounce_back(link.direction, leaving, link.excess_density, u));
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
    std::int64_t beside = 0;               ///< index of x_f + e_t; 0: the flow there does not continue
  };

  const PopulationLayout& layout_;
  Eigen::Vector3d half_force_;
  std::vector<Link> links_;
  std::vector<double> entering_;
};

}  // namespace copepod::fluid
