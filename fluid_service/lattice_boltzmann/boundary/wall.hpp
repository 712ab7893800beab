#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "lattice_boltzmann/boundary/domain.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

// Walls at the faces of the domain, at rest or moving: half-way bounce-back. A population that meets the wall
// returns to the cell that it left, in the opposite direction. A wall at rest costs no time
// (PopulationLayout); a moving one adds its momentum, in place, before the update.

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
  /// @param domain  outlives this object; before its first step, in which a velocity may be zero
  MovingWalls(const Domain& domain, const PopulationLayout& layout) : domain_(domain) {
    for_each_entering(layout.block(), [&](const Cell& ghost, int direction) {
      if (domain.box().contains(ghost)) return;
      const GhostSource source = ghost_source(domain, ghost, direction);
      if (source.addition == 0.0) return;
      if (links_.empty() || !links_.back().is_alike(source))
        links_.push_back({.ghost = ghost, .direction = direction, .source = source, .entries = {}});
      for (const Placement placement : {Placement::home, Placement::streamed})
        links_.back().entries[static_cast<std::size_t>(placement)].add(
            layout.entry(layout.site(source.cell), direction, placement));
    });
  }

  template <class T>
  void apply(T* populations, Placement placement) {
    for (Links& links : links_) {
      if (domain_.varies()) links.source = ghost_source(domain_, links.ghost, links.direction);
      links.entries[static_cast<std::size_t>(placement)].for_each(
          populations, [addition = static_cast<T>(links.source.addition)](T& entering) { entering += addition; });
    }
  }

 private:
  /// Links with the same addition in every step.
  struct Links {
    Cell ghost{};  ///< of the first
    int direction = 0;
    GhostSource source;           ///< of the first
    std::array<Runs, 2> entries;  ///< where the populations that return are read, by placement

    [[nodiscard]] bool is_alike(const GhostSource& other) const {
      return source.addition == other.addition && source.profile == other.profile && source.axis == other.axis &&
             source.high == other.high;
    }
  };
  const Domain& domain_;
  std::vector<Links> links_;
};

}  // namespace copepod::fluid
