#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

// Open faces at a given pressure: anti-bounce-back. The population that leaves is replaced by one that
// enters, so that the density at the face is the given one.

namespace copepod::fluid {

/// The population that enters through a face of given density [Ginzburg, Verhaeghe, d'Humières 2008]:
///   f_ᾱ(x_f) = −f̃_α(x_f) + 2 w_α ρ_w (1 + 9/2 (e·u)² − 3/2 u²)
/// as a deviation from w_ᾱ.
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
  PressureFaces(const Domain& domain, const PopulationLayout& layout, const Eigen::Vector3d& body_force_lu)
      : layout_(layout), half_force_(0.5 * body_force_lu) {
    for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.kind == GhostSource::Kind::pressure)
        links_.push_back({layout.site(source.cell), direction, source.excess_density});
    });
  }

  /// The velocity at the face is that of the fluid cell, u = (Σ f̃ e − F/2) / ρ: a collision adds half of the
  /// force F that belongs to the next half step [Guo, Zheng, Shi 2002]. f̃_α lies where f_ᾱ will be read, so
  /// all of a cell's are computed before one is replaced.
  template <class T>
  void apply(T* populations, Placement placement) {
    entering_.clear();
    for (const Link& link : links_) {
      const Moments<double> m = moments(layout_.gather(populations, link.cell, placement));
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
  };

  const PopulationLayout& layout_;
  Eigen::Vector3d half_force_;
  std::vector<Link> links_;
  std::vector<double> entering_;
};

}  // namespace copepod::fluid
