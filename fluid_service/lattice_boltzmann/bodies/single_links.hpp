#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>

#include <Eigen/Core>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/body_map.hpp"
#include "lattice_boltzmann/bodies/load_sums.hpp"
#include "lattice_boltzmann/kernel/film.hpp"
#include "lattice_boltzmann/kernel/link_formula.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"

namespace copepod::fluid {

namespace single_links {

/// Larger than any population of a flow that makes sense: the sum of all is a density near 1. A cell's links together
/// stay within the range of fixed_point::from_double. Also catches NaN when negated.
constexpr double absurd_population = 2.0;

/// e_α·u, never −0, as exchange_groups has it.
inline double along(int direction, const Eigen::Ref<const Eigen::Vector3d>& u) {
  const auto& e = d3q19::velocity[direction];
  return 0.0 + e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
}

[[noreturn]] inline void throw_diverged(const Cell& cell) {
  throw SolverError("the flow diverged beside a body at cell (" + std::to_string(cell[0]) + ", " +
                    std::to_string(cell[1]) + ", " + std::to_string(cell[2]) +
                    ") (a population is not finite or far too large). Use collision: central_moments, a "
                    "relaxation time nearer to 1, slower motion, or coupling.virtual_mass: auto for light bodies.");
}

/// d(e_α·u)/ds along a link whose second cell, x_f − e_α, is covered or beyond a wall: between the two surfaces,
/// at x_f + q e_α and x_f − q' e_α, the fluid is taken to move as in Couette flow, over a tenth of a link at least,
/// for surfaces that touch. 0 in front of an open face.
inline double slope_between_surfaces(const BodyMap& map, const PopulationLayout& layout, const Cell& at, int alpha,
                                     const Link<double>& link) {
  const auto& e = d3q19::e[alpha];
  const Cell behind = {at[0] - e[0], at[1] - e[1], at[2] - e[2]};
  const Domain& domain = map.domain();
  double e_dot_u = 0.0;
  double distance = 0.5;  // of a face
  if (domain.canonical(behind)) {
    const LatticeBody& other = map.bodies()[map.owner(layout.cell(behind)) - 1];
    const LinkToBody seen = domain.link_to_body(other.position, at, d3q19::opposite(alpha));
    e_dot_u = -along(seen.direction, other.surface_velocity(seen.r));
    distance = wall_distance(other, seen.r, seen.direction);
  } else {
    const GhostSource source = ghost_source(domain, behind, alpha);
    if (source.kind != GhostSource::Kind::wall) return 0.0;
    e_dot_u = source.addition / (6.0 * d3q19::weight(alpha));
  }
  return (link.e_dot_u_w - e_dot_u) / std::max(link.wall_distance + distance, 0.1);
}

}  // namespace single_links

/// The momentum exchange (momentum_exchange.hpp) link by link, for bodies and cells of any kind: links to an image,
/// without a second cell, or with a population of any size.
template <class Formula, class T>
class SingleLinks {
 public:
  SingleLinks(const Formula& formula, const PopulationLayout& layout, const BodyMap& map)
      : formula_(formula), layout_(layout), map_(map) {}

  /// Of one group of a body's boundary cells.
  /// @param place_of_body  in `loads`
  void operator()(std::size_t body_index, std::size_t place_of_body, const CellGroup& group, const FilmsBeside& films,
                  BoundaryValues<T>& boundary, double returned, std::span<LoadSums> loads, MomentumSums& kept) const {
    using namespace single_links;
    LoadSums& sums = loads[place_of_body];
    const Domain& domain = map_.domain();
    const LatticeBody& body = map_.bodies()[body_index];
    for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
      if (group.directions[lane] == 0) continue;
      const Cell cell = cell_of(group, lane);
      const double* const of_cell = boundary.by_cell.data() + per_cell * group.moments[lane];
      const double excess = of_cell[Values::excess_density];
      // One link, the n-th of the cell, as the body sees it: from r in direction `seen`.
      const auto link_at = [&](std::size_t n, int alpha, int seen, const Eigen::Vector3d& r, const Eigen::Vector3d& u)
          __attribute__((always_inline)) {
        const T* const values = boundary.by_link.data() + per_link * (group.first_link[lane] + n);
        Link<double> link{.weight = d3q19::weight(alpha),
                          .leaving = static_cast<double>(values[Values::crossing]),
                          .density = 1.0 + excess,
                          .e_dot_u_w = along(seen, u),
                          .wall_distance = 0.5};
        std::ranges::copy(d3q19::velocity[alpha], link.e);
        if constexpr (Formula::uses_second_cell) {
          link.inward = static_cast<double>(values[Values::inward]);
          link.behind = static_cast<double>(values[Values::behind]);
          link.e_dot_j = along(alpha, Eigen::Map<const Eigen::Vector3d>(of_cell + Values::momentum));
        }
        if constexpr (Formula::uses_wall_distance) link.wall_distance = wall_distance(body, r, seen);
        return link;
      };
      const auto returning = [&](Link<double> & link, int alpha) __attribute__((always_inline)) {
        if (!Formula::uses_second_cell || ((group.second_cells[lane] >> alpha) & 1U) != 0)
          return formula_.returning(link);
        // Bounce-back from half-way along the link, where the fluid between the two surfaces moves with
        //   e_α·u_w + (1/2 − q) d(e_α·u)/ds
        link.e_dot_u_w += (0.5 - link.wall_distance) * slope_between_surfaces(map_, layout_, cell, alpha, link);
        return BounceBack().returning(link);
      };
      double given = Formula::conserving ? returned : 0.0;  // mass, in proportion to w_α
      const auto reflect = [&](std::size_t n, int alpha, int seen, const Eigen::Vector3d& r, const Eigen::Vector3d& u,
                               CellSums& cell_sums) {
        auto& [force, mass, arm] = cell_sums;
        T& population = boundary.by_link[per_link * (group.first_link[lane] + n) + Values::crossing];
        const auto& e = d3q19::e[seen];
        Link<double> link = link_at(n, alpha, seen, r, u);
        double exact = returning(link, alpha);
        if (Formula::conserving || given != 0.0) exact += link.weight * given;
        population = static_cast<T>(exact);
        const auto stored = static_cast<double>(population);
        const double exchanged = link.leaving + stored;
        if (!(std::abs(exchanged) < absurd_population)) throw_diverged(cell);
        const Film<double> film(films, {r[0], r[1], r[2]}, link.wall_distance, d3q19::velocity[seen]);
        const FilmBeside* const beside = film.number < 0 ? nullptr : &films.surfaces[film.number];
        const bool is_shared = beside != nullptr && beside->other >= 0;
        const std::int64_t fixed = fixed_point::from_double(film.resolved * exchanged);
        for (std::size_t axis = 0; axis < 3; ++axis) force[axis] += e[axis] * fixed;
        if (film.resolved < 1.0) {
          const std::int64_t unresolved = fixed_point::from_double(exchanged) - fixed;
          const std::int64_t half = unresolved / 2;
          std::int64_t on_other[3] = {0, 0, 0};
          for (std::size_t axis = 0; axis < 3; ++axis) {
            if (is_shared) {
              force[axis] += e[axis] * (unresolved - half);
              on_other[axis] = e[axis] * half;
            } else {
              kept[axis] += fixed_point::Sum{e[axis]} * unresolved;
            }
          }
          // The body itself: through a periodic face.
          if (is_shared)
            add(r - Eigen::Map<const Eigen::Vector3d>(beside->centre_m) / films.cell_m, on_other, loads[beside->other]);
        }
        if constexpr (Formula::conserving) {
          const double absorbed = link.leaving - stored;
          const std::int64_t at_surface = fixed_point::from_double(film.resolved * absorbed * link.wall_distance);
          for (std::size_t axis = 0; axis < 3; ++axis) arm[axis] += e[axis] * at_surface;
          const std::int64_t fixed_absorbed = fixed_point::from_double(absorbed);
          mass += film.resolved < 1.0 ? fixed_point::from_double(film.resolved * absorbed) : fixed_absorbed;
          sums[mass_component] += fixed_absorbed;
          sums[weight_component] += fixed_point::from_double(link.weight);
        }
      };
      const Eigen::Vector3d r = domain.from_position(body.position, cell);
      const Eigen::Vector3d u = body.surface_velocity(r);
      const std::uint32_t to_images = domain.links_to_images(body.position, r, cell, group.directions[lane]);
      if (std::abs(excess) > largest_excess_density) {
        double gain = 0.0;
        double weight = 0.0;
        std::size_t n = 0;
        for (std::uint32_t bits = group.directions[lane]; bits != 0; bits &= bits - 1, ++n) {
          const int alpha = std::countr_zero(bits);
          const LinkToBody seen = domain.link_to_body(body.position, cell, alpha);
          Link<double> link = link_at(n, alpha, seen.direction, seen.r, body.surface_velocity(seen.r));
          gain += returning(link, alpha) + link.weight * given - link.leaving;
          weight += link.weight;
        }
        if (gain * excess > 0.0) given -= gain / weight;
      }
      CellSums of_links;
      std::size_t n = 0;
      for (std::uint32_t bits = group.directions[lane]; bits != 0; bits &= bits - 1, ++n) {
        const int alpha = std::countr_zero(bits);
        if (((to_images >> alpha) & 1U) == 0) {
          reflect(n, alpha, alpha, r, u, of_links);
          continue;
        }
        const LinkToBody link = domain.link_to_body(body.position, cell, alpha);
        const Eigen::Vector3d u_image = body.surface_velocity(link.r);
        CellSums on_image;
        reflect(n, alpha, link.direction, link.r, u_image, on_image);
        add(body, link.r, u_image, on_image, sums, kept);
      }
      add(body, r, u, of_links, sums, kept);
    }
  }

 private:
  using Values = BoundaryValues<T>;
  static constexpr std::size_t per_link = Values::per_link(Formula::uses_second_cell);
  static constexpr std::size_t per_cell = Values::per_cell(Formula::uses_second_cell);

  [[nodiscard]] Cell cell_of(const CellGroup& group, std::size_t lane) const {
    const Cell& low = layout_.block().low;
    return {low[0] + group.cell[0][lane], low[1] + group.cell[1][lane], low[2] + group.cell[2][lane]};
  }

  /// What the links of a cell exert, in fixed point.
  struct CellSums {
    std::int64_t force[3]{};  ///< Σ e_α (f̃_α + f_ᾱ)
    std::int64_t mass = 0;    ///< absorbed, m = Σ (f̃_α − f_ᾱ)
    std::int64_t arm[3]{};    ///< of its momentum, Σ q e_α (f̃_α − f_ᾱ)
  };

  static Eigen::Vector3d to_doubles(const std::int64_t (&sums)[3]) {
    return {fixed_point::to_double(sums[0]), fixed_point::to_double(sums[1]), fixed_point::to_double(sums[2])};
  }

  /// Force of a cell's links, and its torque, which is rounded cell by cell.
  static void add(const Eigen::Vector3d& r, const std::int64_t (&force)[3], LoadSums& sums,
                  const Eigen::Vector3d& further_torque = Eigen::Vector3d::Zero()) {
    const Eigen::Vector3d torque = r.cross(to_doubles(force)) - further_torque;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sums[axis] += force[axis];
      sums[3 + axis] += fixed_point::sum_from_double(torque[axis]);
    }
  }

  /// The same with the momentum of what the surface absorbs, −Σ u_w (f̃_α − f_ᾱ), u_w = u + Ω × q e_α.
  static void add(const LatticeBody& body, const Eigen::Vector3d& r, const Eigen::Vector3d& u, CellSums& cell,
                  LoadSums& sums, MomentumSums& kept) {
    if constexpr (!Formula::conserving) return add(r, cell.force, sums);
    const Eigen::Vector3d arm = to_doubles(cell.arm);
    const Eigen::Vector3d momentum = fixed_point::to_double(cell.mass) * u + body.angular_velocity.cross(arm);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::int64_t fixed = fixed_point::from_double(momentum[axis]);
      cell.force[axis] -= fixed;
      kept[axis] += fixed;
    }
    add(r, cell.force, sums, arm.cross(u));
  }

  Formula formula_;
  const PopulationLayout& layout_;
  const BodyMap& map_;
};

}  // namespace copepod::fluid
