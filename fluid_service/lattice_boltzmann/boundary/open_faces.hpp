#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

// Open faces. Beyond them the flow continues as it is beside them, but for one thing:
//   f_ᾱ(x_f) = f̃_ᾱ(x_f + e_t) + what changes,   e_t = e_α − n
// x_f + e_t is the cell beside the ghost cell x_f + e_α, across the face with the outward normal n. So a flow that does
// not change along n is a solution of the lattice, whatever its profile, collision and viscosity.

namespace copepod::fluid {

/// At a face of the density ρ_w, the density beyond it is 2 ρ_w − ρ(x_f):
///   2 w_α (ρ_w − ρ(x_f))
/// @param excess_density  ρ_w − 1
/// @param of_cell         ρ(x_f) − 1
inline double change_at_pressure(int direction, double excess_density, double of_cell) {
  return 2.0 * d3q19::weight(direction) * (excess_density - of_cell);
}

/// At an outflow, w_α times this. Waves of sound leave along n, what the flow carries makes none, and the density is
/// drawn to that at rest so weakly that only its mean notices [Poinsot and Lele, J. Comput. Phys. 101, 1992]:
///   ∂ρ/∂t = (∂j/∂t + u ∂j/∂n)/c_s − σ c_s/L (ρ − 1),   j = ρu along n, c_s = 1/√3, σ = 1/10
/// @param of_cell   of x_f
/// @param of_inner  of x_f − n
/// @param arriving  of x_f in the next step, without a change
/// @param added     of w_α, over what enters through the face
/// @param length    L: cells along n
inline double change_at_outflow(const Moments<double>& of_cell, const Moments<double>& of_inner,
                                const Moments<double>& arriving, const Moments<double>& added, int axis, bool high,
                                double length) {
  constexpr double c_s = 0.57735026918962576, sigma = 0.1;
  const auto along = [&](const Moments<double>& m) { return high ? m.momentum[axis] : -m.momentum[axis]; };
  const double u = std::max(0.0, along(of_cell) / (1.0 + of_cell.excess_density));
  const double next = of_cell.excess_density * (1.0 - sigma * c_s / length) +
                      (along(arriving) - along(of_cell) + u * (along(of_cell) - along(of_inner))) / c_s;
  return (next - arriving.excess_density) / (added.excess_density - along(added) / c_s);
}

/// The open faces of one block.
class OpenFaces {
 public:
  /// @throws CaseError if the block is too thin
  OpenFaces(const Domain& domain, const PopulationLayout& layout) : layout_(layout) {
    std::map<std::int64_t, std::pair<OpenCell, std::vector<Link>>> by_place;
    for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.kind != GhostSource::Kind::open) return;
      auto& [cell, links] = by_place[layout.cell(source.cell)];
      cell.site = layout.site(source.cell);
      cell.through_faces |= 1U << direction;
      links.push_back(make_link(domain, ghost, source, direction));
      if (links.back().kind == FaceKind::outflow && cell.length == 0.0) set_outflow(domain, source, cell);
    });
    for (auto& [place, cell_and_links] : by_place) {
      auto& [cell, links] = cell_and_links;
      cell.first_link = links_.size();
      cell.links = links.size();
      cells_.push_back(cell);
      links_.insert(links_.end(), links.begin(), links.end());
    }
  }

  [[nodiscard]] bool empty() const { return cells_.empty(); }

  /// f̃_α lies where f_ᾱ will be read, so all are computed before one is replaced.
  /// @param populations  with those of other ranks
  /// @param is_solid     whether a body covers a cell of the layout
  template <class T, class IsSolid>
  void apply(T* populations, Placement placement, const IsSolid& is_solid) {
    constexpr std::size_t ahead = 8;  // a face normal to z has one cell in a cache line
    entering_.clear();
    for (std::size_t place = 0; place < cells_.size(); ++place) {
      if (place + ahead < cells_.size())
        for (int alpha = 0; alpha < d3q19::directions; ++alpha)
          __builtin_prefetch(populations + layout_.location(cells_[place + ahead].site, alpha, placement));
      const OpenCell& cell = cells_[place];
      const Moments<double> of_cell = moments(layout_.gather(populations, cell.site, placement));
      Populations entering{}, added{};
      for (const Link& link : links_of(cell)) {
        const auto i = static_cast<std::size_t>(link.direction);
        const bool continues = link.beside != 0 && !is_solid(link.beside);
        entering[i] = populations[continues ? link.enters[static_cast<std::size_t>(placement)]
                                            : layout_.location(cell.site, link.direction, placement)];
        if (link.kind == FaceKind::outflow) added[i] = d3q19::weight(link.direction);
        if (link.kind == FaceKind::pressure)
          entering[i] += change_at_pressure(link.direction, link.excess_density, of_cell.excess_density);
      }
      const double change =
          cell.length > 0.0 ? outflow_change(cell, of_cell, entering, added, populations, placement, is_solid) : 0.0;
      for (const Link& link : links_of(cell)) {
        const auto i = static_cast<std::size_t>(link.direction);
        entering_.push_back(entering[i] + added[i] * change);
      }
    }
    auto entering = entering_.begin();
    for (const OpenCell& cell : cells_)
      for (const Link& link : links_of(cell))
        populations[layout_.entry(cell.site, link.direction, placement)] = static_cast<T>(*entering++);
  }

 private:
  struct Link {
    int direction = 0;  ///< ᾱ, into the fluid
    FaceKind kind = FaceKind::outflow;
    double excess_density = 0.0;           ///< of a pressure face
    std::array<std::int64_t, 2> enters{};  ///< where f̃_ᾱ(x_f + e_t) is, by placement
    std::int64_t beside = 0;               ///< index of x_f + e_t; 0: unknown, x_f takes its place
  };
  struct OpenCell {
    Site site;  ///< x_f
    std::size_t first_link = 0;
    std::size_t links = 0;
    // At an outflow:
    double length = 0.0;              ///< L; 0: not at one
    int axis = 0;                     ///< of n
    bool high = false;                ///< n points up
    Site inner;                       ///< x_f − n
    bool beside_walls = false;        ///< that move
    Populations from_walls{};         ///< what they add
    std::uint32_t through_faces = 0;  ///< bit α set: a link
  };

  [[nodiscard]] std::span<const Link> links_of(const OpenCell& cell) const {
    return std::span(links_).subspan(cell.first_link, cell.links);
  }

  [[nodiscard]] Link make_link(const Domain& domain, const Cell& ghost, const GhostSource& source,
                               int direction) const {
    const Face& face = domain.face(source.axis, source.high);
    Link link{direction, face.kind, face.excess_density_lu, {}, 0};
    Cell beside = ghost;       // x_f + e_t
    Cell inner = source.cell;  // x_f − n, which f̃_ᾱ of the cell beside enters, also from another rank
    int open_faces = 0;
    for (int axis = 0; axis < 3; ++axis) {
      if (domain.image(axis, ghost[axis])) continue;
      beside[axis] = source.cell[axis];
      inner[axis] += d3q19::e[direction][axis];
      ++open_faces;
    }
    if (open_faces > 1 || !domain.box().contains(inner)) return link;
    require_in_block(inner);
    link.beside = layout_.cell(beside);
    for (const Placement placement : {Placement::home, Placement::streamed})
      link.enters[static_cast<std::size_t>(placement)] = layout_.entry(layout_.site(inner), direction, placement);
    return link;
  }

  void set_outflow(const Domain& domain, const GhostSource& source, OpenCell& cell) const {
    const std::int64_t length = domain.cells()[source.axis];
    cell.length = static_cast<double>(length);
    cell.axis = source.axis;
    cell.high = source.high;
    Cell inner = source.cell;
    if (length > 1) inner[source.axis] += source.high ? -1 : 1;
    require_in_block(inner);
    cell.inner = layout_.site(inner);
    for (int alpha = 1; alpha < d3q19::directions; ++alpha) {
      const auto& e = d3q19::e[alpha];
      const Cell ghost = {source.cell[0] - e[0], source.cell[1] - e[1], source.cell[2] - e[2]};
      const double addition = ghost_source(domain, ghost, alpha).addition;
      cell.from_walls[static_cast<std::size_t>(alpha)] = addition;
      cell.beside_walls = cell.beside_walls || addition != 0.0;
    }
  }

  void require_in_block(const Cell& cell) const {
    if (!layout_.block().contains(cell))
      throw CaseError("a rank has one layer of cells beside an open face (it needs two). Use fewer ranks.");
  }

  /// @param arriving  through open faces; the other populations are added
  template <class T, class IsSolid>
  [[nodiscard]] double outflow_change(const OpenCell& cell, const Moments<double>& of_cell, Populations arriving,
                                      const Populations& added, const T* populations, Placement placement,
                                      const IsSolid& is_solid) const {
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      if (is_solid(cell.site.index + layout_.neighbour(alpha))) return 0.0;  // what a body sends back is not there yet
    const PopulationLayout::Locations& enters = layout_.locations(cell.site.faces, other(placement));
    for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
      if ((cell.through_faces >> alpha & 1U) != 0) continue;
      const auto i = static_cast<std::size_t>(alpha);
      arriving[i] = populations[cell.site.index + enters[static_cast<std::size_t>(d3q19::opposite(alpha))]];
      if (cell.beside_walls) arriving[i] += cell.from_walls[i];
    }
    return change_at_outflow(of_cell, moments(layout_.gather(populations, cell.inner, placement)), moments(arriving),
                             moments(added), cell.axis, cell.high, cell.length);
  }

  const PopulationLayout& layout_;
  std::vector<OpenCell> cells_;  ///< as they lie in memory
  std::vector<Link> links_;
  std::vector<double> entering_;
};

}  // namespace copepod::fluid
