#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
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

/// Numbers of as many cells, which are computed side by side.
constexpr int cells_together = 16;
using CellValues = Eigen::Array<double, cells_together, 1>;

/// At a face of the density ρ_w, the density beyond it is 2 ρ_w − ρ(x_f):
///   2 w_α (ρ_w − ρ(x_f))
/// @param excess_density  ρ_w − 1
/// @param of_cell         ρ(x_f) − 1
inline CellValues change_at_pressure(int direction, double excess_density, const CellValues& of_cell) {
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
inline CellValues change_at_outflow(const Moments<CellValues>& of_cell, const Moments<CellValues>& of_inner,
                                    const Moments<CellValues>& arriving, const Moments<double>& added, int axis,
                                    bool high, double length) {
  constexpr double c_s = 0.57735026918962576, sigma = 0.1;
  const double sign = high ? 1.0 : -1.0;
  const CellValues j = sign * of_cell.momentum[axis];
  const CellValues u = (j / (1.0 + of_cell.excess_density)).max(0.0);
  const CellValues next = of_cell.excess_density * (1.0 - sigma * c_s / length) +
                          (sign * arriving.momentum[axis] - j + u * (j - sign * of_inner.momentum[axis])) / c_s;
  return (next - arriving.excess_density) / (added.excess_density - sign * added.momentum[axis] / c_s);
}

/// The open faces of one block.
class OpenFaces {
 public:
  /// @param domain  outlives this object; before its first step, in which a velocity may be zero
  /// @throws CaseError if the block is too thin
  OpenFaces(const Domain& domain, const PopulationLayout& layout) : domain_(domain), layout_(layout) {
    std::map<std::int64_t, Cell> cells;  // as they lie in memory
    fluid::for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.kind == GhostSource::Kind::open) cells.emplace(layout.cell(source.cell), source.cell);
    });
    for (const auto& [place, cell] : cells) {
      Group group = group_of(domain, cell);
      const auto same = std::ranges::find_if(groups_, [&](const Kind& other) { return other == group; });
      (same == groups_.end() ? groups_.emplace_back(std::move(group)) : *same).cells.push_back(place);
    }
  }

  [[nodiscard]] bool empty() const { return groups_.empty(); }

  /// Calls visit(place, value) for what enters the fluid in the next step, and where it will be read. There f̃_α lies,
  /// so all are computed before the first is visited.
  /// @param populations  with those of other ranks
  /// @param is_solid     whether a body covers a cell of the layout
  template <class T, class IsSolid, class Visit>
  void for_each_entering(const T* populations, Placement placement, const IsSolid& is_solid, const Visit& visit) {
    entering_.clear();
    for (Group& group : groups_) {
      if (domain_.varies() && group.length > 0.0) set_walls(group);
      for (std::size_t first = 0; first < group.cells.size(); first += cells_together) {
        Cells cells;
        for (std::size_t i = 0; i < cells_together; ++i)  // the group's last cell fills the rest
          cells[i] = group.cells[std::min(first + i, group.cells.size() - 1)];
        compute(group, cells, populations, placement, is_solid);
      }
    }
    auto entering = entering_.begin();
    for (const Group& group : groups_)
      for (std::size_t first = 0; first < group.cells.size(); first += cells_together) {
        const std::size_t count = std::min<std::size_t>(cells_together, group.cells.size() - first);
        for (const Link& link : group.links) {
          const CellValues& values = *entering++;
          const std::int64_t entry = layout_.entry({0, group.faces}, link.direction, placement);
          for (std::size_t i = 0; i < count; ++i) visit(group.cells[first + i] + entry, static_cast<T>(values[i]));
        }
      }
  }

 private:
  using Cells = std::array<std::int64_t, cells_together>;
  using ValuesByDirection = std::array<CellValues, d3q19::directions>;

  struct Link {
    int direction = 0;  ///< ᾱ, into the fluid
    FaceKind kind = FaceKind::outflow;
    double excess_density = 0.0;           ///< of a pressure face
    std::array<std::int64_t, 2> enters{};  ///< where f̃_ᾱ(x_f + e_t) is, from x_f, by placement
    std::int64_t beside = 0;               ///< x_f + e_t, from x_f
    bool continues = false;                ///< x_f + e_t is known; otherwise x_f takes its place

    bool operator==(const Link&) const = default;
  };
  /// What cells x_f have in common that differ in their places only.
  struct Kind {
    Faces faces = 0;
    std::vector<Link> links;
    // At an outflow:
    double length = 0.0;        ///< L; 0: not at one
    int axis = 0;               ///< of n
    bool high = false;          ///< n points up
    Faces faces_of_inner = 0;   ///< of x_f − n
    std::int64_t to_inner = 0;  ///< x_f − n, from x_f
    Populations from_walls{};   ///< what moving walls add
    Populations profiles{};     ///< of their faces
    bool operator==(const Kind&) const = default;
  };
  struct Group : Kind {
    Cell first{};
    std::vector<std::int64_t> cells;
  };

  [[nodiscard]] Group group_of(const Domain& domain, const Cell& cell) const {
    Group group;
    group.first = cell;
    group.faces = layout_.site(cell).faces;
    for (int direction = 1; direction < d3q19::directions; ++direction) {
      const auto& e = d3q19::e[direction];
      const Cell ghost = {cell[0] - e[0], cell[1] - e[1], cell[2] - e[2]};
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.kind != GhostSource::Kind::open) continue;
      group.links.push_back(make_link(domain, ghost, source, direction));
      if (group.links.back().kind == FaceKind::outflow && group.length == 0.0) set_outflow(domain, source, group);
    }
    if (group.length > 0.0) set_walls(group);
    return group;
  }

  void set_walls(Group& group) const {
    for (int direction = 1; direction < d3q19::directions; ++direction) {
      const auto& e = d3q19::e[direction];
      const Cell ghost = {group.first[0] - e[0], group.first[1] - e[1], group.first[2] - e[2]};
      const GhostSource source = ghost_source(domain_, ghost, direction);
      group.from_walls[direction] = source.addition;
      group.profiles[direction] = source.profile;
    }
  }

  [[nodiscard]] Link make_link(const Domain& domain, const Cell& ghost, const GhostSource& source,
                               int direction) const {
    const Face& face = domain.face(source.axis, source.high);
    Link link{direction, face.kind, face.excess_density_lu, {}, 0, false};
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
    const std::int64_t place = layout_.cell(source.cell);
    link.continues = true;
    link.beside = layout_.cell(beside) - place;
    for (const Placement placement : {Placement::home, Placement::streamed})
      link.enters[static_cast<std::size_t>(placement)] =
          layout_.entry(layout_.site(inner), direction, placement) - place;
    return link;
  }

  void set_outflow(const Domain& domain, const GhostSource& source, Group& group) const {
    const std::int64_t length = domain.cells()[source.axis];
    group.length = static_cast<double>(length);
    group.axis = source.axis;
    group.high = source.high;
    Cell inner = source.cell;
    if (length > 1) inner[source.axis] += source.high ? -1 : 1;
    require_in_block(inner);
    group.faces_of_inner = layout_.site(inner).faces;
    group.to_inner = layout_.cell(inner) - layout_.cell(source.cell);
  }

  void require_in_block(const Cell& cell) const {
    if (!layout_.block().contains(cell))
      throw CaseError("a rank has one layer of cells beside an open face (it needs two). Use fewer ranks.");
  }

  template <class T>
  [[nodiscard]] static CellValues load(const T* populations, const Cells& cells, std::int64_t offset) {
    CellValues values;
    for (std::size_t i = 0; i < cells_together; ++i) values[i] = populations[cells[i] + offset];
    return values;
  }

  template <class T>
  [[nodiscard]] Moments<CellValues> moments_of(const T* populations, const Cells& cells, Faces faces,
                                               Placement placement, std::int64_t offset = 0) const {
    ValuesByDirection values;
    for (std::size_t alpha = 0; alpha < values.size(); ++alpha)
      values[alpha] = load(populations, cells, offset + layout_.locations(faces, placement)[alpha]);
    return moments(values);
  }

  /// Appends what enters each cell, link by link.
  template <class T, class IsSolid>
  void compute(const Group& group, const Cells& cells, const T* populations, Placement placement,
               const IsSolid& is_solid) {
    const Moments<CellValues> of_cell = moments_of(populations, cells, group.faces, placement);
    ValuesByDirection arriving;
    Populations added{};
    std::uint32_t through_faces = 0;
    for (const Link& link : group.links) {
      const int alpha = link.direction;
      const std::int64_t own = layout_.location({0, group.faces}, alpha, placement);
      for (std::size_t i = 0; i < cells_together; ++i) {
        const bool continues = link.continues && !is_solid(cells[i] + link.beside);
        arriving[alpha][i] =
            populations[cells[i] + (continues ? link.enters[static_cast<std::size_t>(placement)] : own)];
      }
      if (link.kind == FaceKind::pressure)
        arriving[alpha] += change_at_pressure(link.direction, link.excess_density, of_cell.excess_density);
      if (link.kind == FaceKind::outflow) added[alpha] = d3q19::weight(link.direction);
      through_faces |= 1U << link.direction;
    }
    CellValues change = CellValues::Zero();
    if (group.length > 0.0) {
      for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
        if ((through_faces >> alpha & 1U) != 0) continue;
        arriving[alpha] =
            load(populations, cells, layout_.entry({0, group.faces}, alpha, placement)) + group.from_walls[alpha];
      }
      change =
          change_at_outflow(of_cell, moments_of(populations, cells, group.faces_of_inner, placement, group.to_inner),
                            moments(arriving), moments(added), group.axis, group.high, group.length);
      for (std::size_t i = 0; i < cells_together; ++i)
        if (is_beside_solid(cells[i], is_solid)) change[i] = 0.0;
    }
    for (const Link& link : group.links)
      entering_.emplace_back(arriving[link.direction] + added[link.direction] * change);
  }

  /// What a body sends back has not arrived yet.
  template <class IsSolid>
  [[nodiscard]] bool is_beside_solid(std::int64_t cell, const IsSolid& is_solid) const {
    for (int alpha = 0; alpha < d3q19::directions; ++alpha)
      if (is_solid(cell + layout_.neighbour(alpha))) return true;
    return false;
  }

  const Domain& domain_;
  const PopulationLayout& layout_;
  std::vector<Group> groups_;
  std::vector<CellValues> entering_;
};

}  // namespace copepod::fluid
