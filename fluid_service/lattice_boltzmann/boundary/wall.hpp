#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "contract/errors.hpp"
#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

// Walls at the faces of the domain, at rest or moving: half-way bounce-back. A population that meets the wall
// returns to the cell that it left, in the opposite direction. A wall at rest costs no time
// (PopulationLayout); a moving one adds its momentum, in place, before the update.

// Open faces at a given pressure: the flow continues beyond them as it is, and the density so that it is the given one
// at the face.

namespace copepod::fluid {

/// Places in an array, kept as runs of equal stride.
class Runs {
 public:
  struct Run {
    std::int64_t first = 0;
    std::int64_t stride = 1;
    std::int64_t count = 1;
  };

  void add(std::int64_t place) {
    ++values_;
    if (!runs_.empty()) {
      Run& run = runs_.back();
      const std::int64_t step = place - run.first;
      if (run.count == 1 && step != 0) run.stride = step;
      if (step == run.count * run.stride) {
        ++run.count;
        return;
      }
    }
    runs_.push_back({.first = place});
  }

  [[nodiscard]] const std::vector<Run>& runs() const { return runs_; }
  [[nodiscard]] std::int64_t values() const { return values_; }

  /// visit(array[place]) for every place, in the order in which they were added.
  template <class T, class Visit>
  void for_each(T* array, Visit visit) const {
    for (const Run& run : runs_) {
      T* const first = array + run.first;
      if (run.stride == 1)
        for (std::int64_t i = 0; i < run.count; ++i) visit(first[i]);
      else
        for (std::int64_t i = 0; i < run.count; ++i) visit(first[i * run.stride]);
    }
  }

 private:
  std::vector<Run> runs_;
  std::int64_t values_ = 0;
};

/// What a moving wall adds to the population that it sends back in direction ᾱ:
///   f_ᾱ(x_f) = f̃_α(x_f) + 6 w_α ρ_w e_ᾱ·u_w,   ρ_w = 1                   [paper, moving-wall bounce-back]
/// @param direction  ᾱ, into the fluid
inline double moving_wall_addition(int direction, const Eigen::Vector3d& u_w) {
  const auto& e = d3q19::e[direction];
  return 6.0 * d3q19::weight(direction) * (e[0] * u_w[0] + e[1] * u_w[1] + e[2] * u_w[2]);
}

/// The moving walls beside one block.
class MovingWalls {
 public:
  MovingWalls(const Domain& domain, const PopulationLayout& layout) {
    for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.addition == 0.0) return;
      if (links_.empty() || links_.back().addition != source.addition) links_.push_back({source.addition, {}});
      for (const Placement placement : {Placement::home, Placement::streamed})
        links_.back().entries[static_cast<std::size_t>(placement)].add(
            layout.entry(layout.site(source.cell), direction, placement));
    });
  }

  template <class T>
  void apply(T* populations, Placement placement) const {
    for (const Links& links : links_)
      links.entries[static_cast<std::size_t>(placement)].for_each(
          populations, [addition = static_cast<T>(links.addition)](T& entering) { entering += addition; });
  }

 private:
  /// Links with the same addition.
  struct Links {
    double addition = 0.0;
    std::array<Runs, 2> entries;  ///< where the populations that return are read, by placement
  };
  std::vector<Links> links_;
};

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
