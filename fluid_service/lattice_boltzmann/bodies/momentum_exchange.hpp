#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/boundary_links.hpp"
#include "lattice_boltzmann/bodies/load_sums.hpp"
#include "lattice_boltzmann/bodies/single_links.hpp"
#include "lattice_boltzmann/bodies/thin_films.hpp"
#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/kernel/exchange_group.hpp"
#include "lattice_boltzmann/kernel/link_formula.hpp"

namespace copepod::fluid {

/// Sends back what meets a body, by a link formula (link_formula.hpp), and adds up the momentum that the body
/// takes [paper, section 2.3; Yu et al. 2003; Ladd 1994]:
///   u_w = U + Ω × (x_f − X)
///   F = Σ_links e_α (f̃_α + f_ᾱ),   T = Σ_links (x_f − X) × e_α (f̃_α + f_ᾱ)
/// Every point of a link gives the same torque and the same e_α·u_w, so x_f stands for the wall point.
///
/// Conserving formulas also count the mass that the surface absorbs, m = Σ_links (f̃_α − f_ᾱ), and its momentum,
/// which makes force and torque Galilean invariant [Wen et al. 2014]:
///   F' = −Σ_links u_w (f̃_α − f_ᾱ),   T' = −Σ_links (x_w − X) × u_w (f̃_α − f_ᾱ)
/// with u_w at the wall point x_w = x_f + q e_α: with that of x_f a sphere that turns while it moves would be off by
/// Ω × U times half a cell on its whole surface. In T', Σ q² (f̃_α − f_ᾱ) e_α × (Ω × e_α) is neglected: it cancels on
/// opposite sides. What a surface has absorbed it gives back within some steps, with f_ᾱ, in proportion to w_α: almost
/// without momentum.
///
/// Where the density is beyond that of any flow (largest_excess_density), what a surface sends back into a cell adds up
/// to what it received, or to what brings the density nearer to 1: surfaces do not compress fluid without bound in
/// cells that have few neighbours in the fluid, or none. The film between them has its own model (coupler).
///
/// Populations are deviations f − w: the constant pressure of the fluid at rest never enters, and bodies that
/// touch feel no spurious force from links that are missing between them.
template <class T>
class MomentumExchange {
 public:
  const bool uses_second_cell;  ///< other ranks' populations must have arrived before
  const bool conserving;

  virtual ~MomentumExchange() = default;

  /// Of bodies that leave thin films out of their loads. What the two bodies on both sides of a film leave out is
  /// opposite but for what the fluid around the film exerts on both: each receives half of the sum, so that no momentum
  /// is lost.
  /// @param bodies    those near this rank
  /// @param links     on this rank, with the populations after the bulk update; f_ᾱ replaces f̃_α
  /// @param returned  mass to be given back by each of `bodies`, by the weight of its links
  /// @param loads     of each, sums to which this rank's share is added
  /// @param kept_back likewise: momentum that left the fluid, but is not in the loads
  /// @throws SolverError if a population is not finite or absurdly large, naming the cell
  virtual void operator()(std::span<const std::int32_t> bodies, BoundaryLinks<T>& links,
                          std::span<const double> returned, std::span<LoadSums> loads,
                          MomentumSums& kept_back) const = 0;

 protected:
  MomentumExchange(bool second_cell, bool conserves) : uses_second_cell(second_cell), conserving(conserves) {}
};

template <class Formula, class T>
class MomentumExchangeBy final : public MomentumExchange<T> {
 public:
  MomentumExchangeBy(const Formula& formula, const PopulationLayout& layout, const BodyMap& map, const ThinFilms& films)
      : MomentumExchange<T>(Formula::uses_second_cell, Formula::conserving),
        formula_(formula),
        layout_(layout),
        map_(map),
        films_(films),
        single_links_(formula, layout, map),
        exchange_groups_(std::get<ExchangeGroupsBy<Formula, T>>(choose_kernels<T>().exchange_groups)) {}

  void operator()(std::span<const std::int32_t> bodies, BoundaryLinks<T>& links, std::span<const double> returned,
                  std::span<LoadSums> loads, MomentumSums& kept_back) const override {
    std::vector<const CellGroup*> groups = in_order(bodies, links);
    std::vector<double> distances;
    const CellGroup** group = groups.data();
    for (std::size_t place = 0; place < bodies.size(); ++place) {
      const auto body = static_cast<std::size_t>(bodies[place]);
      const std::size_t count = links.of_body(body).groups.size();
      exchange(body, place, {group, count}, links.values(), returned[place], loads, kept_back,
               map_.is_obstacle(bodies[place]) ? links.of_body(body).wall_distances : distances);
      group += count;
    }
  }

 private:
  /// Cell groups of one body after the other. The last one is there as often as it is asked for ahead.
  static std::vector<const CellGroup*> in_order(std::span<const std::int32_t> bodies, const BoundaryLinks<T>& links) {
    const auto groups_of = [&](int body) -> const std::vector<CellGroup>& { return links.of_body(body).groups; };
    std::size_t count = 2 * groups_ahead;
    for (const std::int32_t body : bodies) count += groups_of(body).size();
    std::vector<const CellGroup*> groups;
    groups.reserve(count);
    for (const std::int32_t body : bodies)
      for (const CellGroup& group : groups_of(body)) groups.push_back(&group);
    if (!groups.empty()) groups.insert(groups.end(), 2 * groups_ahead, groups.back());
    return groups;
  }

  void exchange(std::size_t body, std::size_t place, std::span<const CellGroup*> groups, BoundaryValues<T>& values,
                double returned, std::span<LoadSums> loads, MomentumSums& kept_back,
                std::vector<double>& distances) const {
    const bool by_lanes = is_simple(map_.bodies()[body]);
    BodyInBlock in_block;
    FilmsBeside films = films_.beside(body);
    CellGroup alone, rest;
    if (by_lanes) in_block = place_in_block(map_.bodies()[body], groups, returned);
    in_block.films = &films;
    const ShapeKind kind = map_.bodies()[body].kind;
    const bool has_distances =
        by_lanes && Formula::uses_wall_distance && kind != ShapeKind::sphere && kind != ShapeKind::ellipsoid;
    const bool moves = !map_.is_obstacle(static_cast<std::int32_t>(body));
    if (has_distances && !moves && distances.empty()) set_wall_distances(map_.bodies()[body], groups, distances);
    const std::size_t most = has_distances && moves ? most_distances : LaneSums::most_groups;
    for (std::size_t start = 0; start < groups.size(); start += most) {
      const std::size_t end = std::min(groups.size(), start + most);
      if (has_distances && moves)
        set_wall_distances(map_.bodies()[body], groups.subspan(start, end - start), distances);
      for (std::size_t g = start; g < end;) {
        if (by_lanes) {
          LaneSums lanes;
          if (has_distances)
            in_block.wall_distances = distances.data() + (moves ? g - start : g) * BodyInBlock::distances_per_group;
          g += exchange_groups_(formula_, in_block, groups.data() + g, end - g, values, lanes);
          const auto sum = [](const Lanes<std::int64_t>& of_lanes) {
            return std::accumulate(of_lanes.begin(), of_lanes.end(), fixed_point::Sum{0});
          };
          for (std::size_t i = 0; i < load_components; ++i) loads[place][i] += sum(lanes.sums[i]);
          for (std::size_t axis = 0; axis < 3; ++axis) kept_back[axis] += sum(lanes.sums[load_components + axis]);
          for (FilmBeside& film : films.surfaces)
            for (std::size_t i = 0; film.other >= 0 && i < FilmBeside::components; ++i)
              loads[film.other][i] += sum(std::exchange(film.sums[i], {}));
        }
        if (g == end) break;
        if (by_lanes && Formula::uses_second_cell && take_apart(*groups[g], alone, rest)) {
          single_links_(body, place, alone, films, values, returned, loads, kept_back);
          groups[g] = &rest;
          continue;
        }
        if (!by_lanes) prefetch_ahead<per_link, per_cell>(groups.data() + g, values);
        single_links_(body, place, *groups[g++], films, values, returned, loads, kept_back);
      }
    }
  }

  /// Cells of a group that lack second cells, and the others; false if there are only such or only others.
  static bool take_apart(const CellGroup& group, CellGroup& alone, CellGroup& rest) {
    alone = rest = group;
    for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
      const std::uint32_t directions = group.directions[lane];
      if (directions != 0) ((directions & ~group.second_cells[lane]) != 0 ? rest : alone).set_free(lane);
    }
    return alone.used > 0 && rest.used > 0;
  }

  /// Where the links of groups cross the surface; 1 in free lanes.
  void set_wall_distances(const LatticeBody& body, std::span<const CellGroup* const> groups,
                          std::vector<double>& distances) const {
    distances.resize(groups.size() * BodyInBlock::distances_per_group);
    const Cell& low = layout_.block().low;
    double* of_group = distances.data();
    for (const CellGroup* const group : groups) {
      std::fill_n(of_group, group->links * surface_lanes, 1.0);
      for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
        const auto& at = group->cell;
        const Eigen::Vector3d r = map_.domain().from_position(
            body.position, {low[0] + at[0][lane], low[1] + at[1][lane], low[2] + at[2][lane]});
        std::size_t place = lane;
        for (std::uint32_t bits = group->directions[lane]; bits != 0; bits &= bits - 1, place += surface_lanes)
          of_group[place] = wall_distance(body, r, std::countr_zero(bits));
      }
      of_group += BodyInBlock::distances_per_group;
    }
  }

  /// Whether the links of a body are what exchange_groups is for: into one image of it, or into any of an obstacle,
  /// which does not move, so that only its torque depends on the image.
  [[nodiscard]] bool is_simple(const LatticeBody& body) const {
    const Domain& domain = map_.domain();
    const Eigen::AlignedBox3d bounds = body.bounds();
    for (int axis = 0; axis < 3; ++axis) {
      const double reach = std::max(bounds.max()[axis], -bounds.min()[axis]) + 2.0;
      const auto cells = static_cast<double>(domain.cells()[axis]);
      const double x = body.position[axis];
      if (domain.periodic(axis)) {
        if (!body.has_loads) continue;
        // The same image from all its cells, which are neither beyond a seam nor nearly half a domain away.
        const double inside = x - cells * std::floor(x / cells);
        if (inside < reach || inside > cells - reach || 2.0 * reach > cells - 2.0) return false;
      } else if (domain.has_mirror(axis) && (x < reach || x > cells - reach)) {
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] BodyInBlock place_in_block(const LatticeBody& body, std::span<const CellGroup* const> groups,
                                           double returned) const {
    BodyInBlock result;
    const Eigen::AlignedBox3d bounds = body.bounds();
    result.radius = body.kind == ShapeKind::sphere ? body.radius : bounds.max().cwiseMax(-bounds.min()).norm();
    if (body.kind == ShapeKind::ellipsoid) result.form = body.form.data();
    result.returned = returned;
    const auto used = std::ranges::find_if(groups, [](const CellGroup* g) { return g->used > 0; });
    if (used == groups.end()) return result;
    const CellGroup& group = **used;
    const auto lane = std::ranges::find_if(group.directions, [](std::uint32_t d) { return d != 0; });
    const auto any = static_cast<std::size_t>(lane - group.directions.begin());
    for (int axis = 0; axis < 3; ++axis) {
      result.first_cell[axis] = static_cast<double>(layout_.block().low[axis]) + 0.5;
      result.position[axis] = body.position[axis];
      result.velocity[axis] = body.velocity[axis];
      result.angular_velocity[axis] = body.angular_velocity[axis];
      if (!map_.domain().periodic(axis)) continue;
      const auto length = static_cast<double>(map_.domain().cells()[axis]);
      const double r = result.first_cell[axis] + group.cell[axis][any] - body.position[axis];
      result.image[axis] = length * std::round(r / length);
    }
    return result;
  }

  static constexpr std::size_t per_link = BoundaryValues<T>::per_link(Formula::uses_second_cell);
  static constexpr std::size_t per_cell = BoundaryValues<T>::per_cell(Formula::uses_second_cell);
  static constexpr std::size_t most_distances = 64;  ///< groups for which wall distances are there at a time

  Formula formula_;
  const PopulationLayout& layout_;
  const BodyMap& map_;
  const ThinFilms& films_;
  SingleLinks<Formula, T> single_links_;
  ExchangeGroupsBy<Formula, T> exchange_groups_;
};

/// With the link formula of a case.
/// @throws CaseError for one that this version does not have
template <class T>
std::unique_ptr<MomentumExchange<T>> make_momentum_exchange(MovingBoundary formula,
                                                            const CollisionConstants<T>& collision,
                                                            const PopulationLayout& layout, const BodyMap& map,
                                                            const ThinFilms& films) {
  const auto by = [&]<class Formula>(const Formula& chosen) -> std::unique_ptr<MomentumExchange<T>> {
    return std::make_unique<MomentumExchangeBy<Formula, T>>(chosen, layout, map, films);
  };
  switch (formula) {
    case MovingBoundary::bounce_back:
      return by(BounceBack());
    case MovingBoundary::interpolated:
      return by(Interpolated());
    case MovingBoundary::parabolic:
      return by(Parabolic(collision));
    case MovingBoundary::central_linear:
      return by(CentralLinear());
  }
  throw CaseError("unknown moving_boundary (a newer coupler?). Use bounce_back.");
}

}  // namespace copepod::fluid
