#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/boundary_links.hpp"
#include "lattice_boltzmann/bodies/thin_films.hpp"
#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/kernel/exchange_group.hpp"
#include "lattice_boltzmann/kernel/link_formula.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

namespace copepod::fluid {

/// Force and torque as integers: sums are exact, so neither the order of links nor the number of ranks
/// matters. One unit is 2⁻⁵⁰ ≈ 9e-16 in lattice units.
///
/// What one cell adds to a force fits 64 bits (±8192), the sums over a body need more: the torque of the
/// first step grows with the cube of the radius. They have 128 bits, and no body is too large for them.
namespace fixed_point {

__extension__ using Sum = __int128;

inline constexpr double unit = 0x1p-50;

/// @param value  below 8192
inline std::int64_t from_double(double value) { return std::llrint(value * (1.0 / unit)); }
inline double to_double(std::int64_t value) { return static_cast<double>(value) * unit; }

/// The same for any value. From 2⁵³ units on a double is a multiple of the unit by itself.
inline Sum sum_from_double(double value) {
  return std::abs(value) < 4096.0 ? Sum{from_double(value)} : static_cast<Sum>(value * (1.0 / unit));
}
inline double to_double(Sum value) { return static_cast<double>(value) * unit; }

/// A sum as low + 2⁴⁴ high with 0 ≤ low < 2⁴⁴, for messages: each half is added up by itself, which is exact
/// for 2¹⁹ ranks and sums up to 2⁵⁷ ≈ 1.4e17 in lattice units. 10⁹ links at 10⁴ cells from the centre, all
/// with the largest population that is let through, stay below 10¹⁶.
using Halves = std::array<std::int64_t, 2>;
inline constexpr int low_bits = 44;

inline Halves halves(Sum value) {
  return {static_cast<std::int64_t>(value & ((Sum{1} << low_bits) - 1)), static_cast<std::int64_t>(value >> low_bits)};
}
inline Sum from_halves(std::int64_t low, std::int64_t high) { return low + (Sum{high} << low_bits); }

}  // namespace fixed_point

/// Sums per body: force x, y, z, torque x, y, z, mass absorbed, weights w_α of the links.
inline constexpr std::size_t load_components = 8;
inline constexpr std::size_t mass_component = 6;
inline constexpr std::size_t weight_component = 7;
using LoadSums = std::array<fixed_point::Sum, load_components>;
/// x, y, z.
using MomentumSums = std::array<fixed_point::Sum, 3>;

namespace momentum_exchange {

/// Larger than any population of a flow that makes sense, and a cell's links together stay within the range
/// of fixed_point::from_double; also catches NaN when negated.
constexpr double absurd_population = 1e2;

/// e_α·u, never −0, as exchange_groups has it.
inline double along(int direction, const Eigen::Ref<const Eigen::Vector3d>& u) {
  const auto& e = d3q19::velocity[static_cast<std::size_t>(direction)];
  return 0.0 + e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
}

[[noreturn]] inline void throw_diverged(const Cell& cell) {
  throw SolverError("the flow diverged beside a body at cell (" + std::to_string(cell[0]) + ", " +
                    std::to_string(cell[1]) + ", " + std::to_string(cell[2]) +
                    ") (a population is not finite or far too large). Use a larger relaxation time, weaker forces, or "
                    "coupling.virtual_mass: auto for light bodies.");
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
    const LatticeBody& other = map.bodies()[static_cast<std::size_t>(map.owner(layout.cell(behind)) - 1)];
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

}  // namespace momentum_exchange

/// Sends back what meets a body, by a link formula (link_formula.hpp), and adds up the momentum that the body
/// takes [paper, section 2.3; Yu et al. 2003; Ladd 1994]:
///   u_w = U + Ω × (x_f − X)
///   F = Σ_links e_α (f̃_α + f_ᾱ),   T = Σ_links (x_f − X) × e_α (f̃_α + f_ᾱ)
/// Every point of a link gives the same torque and the same e_α·u_w, so x_f stands for the wall point.
///
/// Conserving formulas also count the mass that the surface absorbs, m = Σ_links (f̃_α − f_ᾱ), and its momentum,
/// −Σ_links u_w (f̃_α − f_ᾱ), which makes the force Galilean invariant [Wen et al. 2014]. What a surface has
/// absorbed it gives back within some steps, with f_ᾱ, in proportion to w_α: almost without momentum.
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

  MomentumExchange(const MomentumExchange&) = delete;
  MomentumExchange& operator=(const MomentumExchange&) = delete;
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
        exchange_groups_(std::get<ExchangeGroupsBy<Formula, T>>(choose_exchange_groups<T>())) {}

  void operator()(std::span<const std::int32_t> bodies, BoundaryLinks<T>& links, std::span<const double> returned,
                  std::span<LoadSums> loads, MomentumSums& kept_back) const override {
    const std::vector<const CellGroup*> groups = in_order(bodies, links);
    const CellGroup* const* group = groups.data();
    for (std::size_t place = 0; place < bodies.size(); ++place) {
      const auto body = static_cast<std::size_t>(bodies[place]);
      const std::size_t count = links.of_body(body).groups.size();
      exchange(body, place, {group, count}, links.values(), returned[place], loads, kept_back);
      group += count;
    }
  }

 private:
  /// Cell groups of one body after the other. The last one is there as often as it is asked for ahead.
  static std::vector<const CellGroup*> in_order(std::span<const std::int32_t> bodies, const BoundaryLinks<T>& links) {
    std::vector<const CellGroup*> groups;
    for (const std::int32_t body : bodies)
      for (const CellGroup& group : links.of_body(static_cast<std::size_t>(body)).groups) groups.push_back(&group);
    if (!groups.empty()) groups.insert(groups.end(), 2 * groups_ahead, groups.back());
    return groups;
  }

  void exchange(std::size_t body, std::size_t place, std::span<const CellGroup* const> groups,
                BoundaryValues<T>& values, double returned, std::span<LoadSums> loads, MomentumSums& kept_back) const {
    const bool by_lanes = is_simple(body);
    SphereInBlock sphere;
    if (by_lanes) sphere = in_block(map_.bodies()[body], groups, returned);
    for (std::size_t g = 0; g < groups.size();) {
      const std::size_t end = std::min(groups.size(), g + LaneSums::most_groups);
      if (by_lanes) {
        LaneSums lanes;
        g += exchange_groups_(formula_, sphere, groups.data() + g, end - g, values, lanes);
        const auto sum = [](const Lanes<std::int64_t>& of_lanes) {
          return std::accumulate(of_lanes.begin(), of_lanes.end(), fixed_point::Sum{0});
        };
        for (std::size_t i = 0; i < load_components; ++i) loads[place][i] += sum(lanes.sums[i]);
        for (std::size_t axis = 0; axis < 3; ++axis) kept_back[axis] += sum(lanes.sums[load_components + axis]);
      }
      if (g == end) continue;
      if (!by_lanes) prefetch_ahead<per_link, per_cell>(groups.data() + g, values);
      exchange_one_by_one(body, place, *groups[g++], values, returned, loads, kept_back);
    }
  }

  /// Whether the links of a body are what exchange_groups is for: into a sphere, itself or one image of it, whose loads
  /// no film is left out of.
  [[nodiscard]] bool is_simple(std::size_t index) const {
    const LatticeBody& body = map_.bodies()[index];
    if (body.kind != ShapeKind::sphere || films_.beside(index)) return false;
    const Domain& domain = map_.domain();
    const double reach = body.radius + 2.0;
    for (int axis = 0; axis < 3; ++axis) {
      const auto cells = static_cast<double>(domain.cells()[axis]);
      const double x = body.position[axis];
      if (domain.periodic(axis)) {
        // The same image from all its cells, which are neither beyond a seam nor nearly half a domain away.
        const double inside = x - cells * std::floor(x / cells);
        if (inside < reach || inside > cells - reach || 2.0 * reach > cells - 2.0) return false;
      } else if (domain.has_mirror(axis) && (x < reach || x > cells - reach)) {
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] SphereInBlock in_block(const LatticeBody& body, std::span<const CellGroup* const> groups,
                                       double returned) const {
    SphereInBlock sphere;
    sphere.radius = body.radius;
    sphere.returned = returned;
    for (int axis = 0; axis < 3; ++axis) {
      const auto low = static_cast<double>(layout_.block().low[axis]);
      sphere.first_cell[axis] = low + 0.5;
      sphere.position[axis] = body.position[axis];
      sphere.velocity[axis] = body.velocity[axis];
      sphere.angular_velocity[axis] = body.angular_velocity[axis];
    }
    const auto used = std::ranges::find_if(groups, [](const CellGroup* g) { return g->used > 0; });
    if (used == groups.end()) return sphere;
    const CellGroup& group = **used;
    const auto lane = std::ranges::find_if(group.directions, [](std::uint32_t d) { return d != 0; });
    const Cell cell = cell_of(group, static_cast<std::size_t>(lane - group.directions.begin()));
    for (int axis = 0; axis < 3; ++axis)
      if (map_.domain().periodic(axis)) {
        const auto length = static_cast<double>(map_.domain().cells()[axis]);
        const double r = (static_cast<double>(cell[axis]) + 0.5) - body.position[axis];
        sphere.image[axis] = length * std::round(r / length);
      }
    return sphere;
  }

  void exchange_one_by_one(std::size_t body_index, std::size_t place_of_body, const CellGroup& group,
                           BoundaryValues<T>& boundary, [[maybe_unused]] double returned, std::span<LoadSums> loads,
                           MomentumSums& kept) const {
    using Values = BoundaryValues<T>;
    LoadSums& sums = loads[place_of_body];
    using namespace momentum_exchange;
    const Domain& domain = map_.domain();
    const LatticeBody& body = map_.bodies()[body_index];
    const bool beside_films = films_.beside(body_index);
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
        std::ranges::copy(d3q19::velocity[static_cast<std::size_t>(alpha)], link.e);
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
                               std::int64_t(&force)[3]) {
        T& population = boundary.by_link[per_link * (group.first_link[lane] + n) + Values::crossing];
        const auto& e = d3q19::e[static_cast<std::size_t>(seen)];
        Link<double> link = link_at(n, alpha, seen, r, u);
        double exact = returning(link, alpha);
        if (Formula::conserving || given != 0.0) exact += link.weight * given;
        population = static_cast<T>(exact);
        const auto stored = static_cast<double>(population);
        const double exchanged = link.leaving + stored;
        if (!(std::abs(exchanged) < absurd_population)) throw_diverged(cell);
        ThinFilms::Film film;
        if (beside_films) film = films_.film(body_index, r + link.wall_distance * Eigen::Vector3d(e[0], e[1], e[2]));
        const std::int64_t fixed = fixed_point::from_double(film.resolved * exchanged);
        for (std::size_t axis = 0; axis < 3; ++axis) force[axis] += e[axis] * fixed;
        if (film.resolved < 1.0) {
          const std::int64_t unresolved = fixed_point::from_double(exchanged) - fixed;
          const std::int64_t half = unresolved / 2;
          std::int64_t on_other[3] = {0, 0, 0};
          for (std::size_t axis = 0; axis < 3; ++axis) {
            if (film.other < 0) {
              kept[axis] += fixed_point::Sum{e[axis]} * unresolved;
            } else {
              force[axis] += e[axis] * (unresolved - half);
              on_other[axis] = e[axis] * half;
            }
          }
          // The body itself: through a periodic face.
          if (film.other >= 0) add(r - film.other_centre, on_other, loads[static_cast<std::size_t>(film.other)]);
        }
        if constexpr (Formula::conserving) {
          const double absorbed = link.leaving - stored;
          for (int axis = 0; axis < 3; ++axis) {
            const std::int64_t of_absorbed = fixed_point::from_double(film.resolved * absorbed * u[axis]);
            force[axis] -= of_absorbed;
            kept[static_cast<std::size_t>(axis)] += of_absorbed;
          }
          sums[mass_component] += fixed_point::from_double(absorbed);
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
      std::int64_t force[3] = {0, 0, 0};
      std::size_t n = 0;
      for (std::uint32_t bits = group.directions[lane]; bits != 0; bits &= bits - 1, ++n) {
        const int alpha = std::countr_zero(bits);
        if (((to_images >> alpha) & 1U) == 0) {
          reflect(n, alpha, alpha, r, u, force);
          continue;
        }
        const LinkToBody link = domain.link_to_body(body.position, cell, alpha);
        std::int64_t on_image[3] = {0, 0, 0};
        reflect(n, alpha, link.direction, link.r, body.surface_velocity(link.r), on_image);
        add(link.r, on_image, sums);
      }
      add(r, force, sums);
    }
  }

  [[nodiscard]] Cell cell_of(const CellGroup& group, std::size_t lane) const {
    const Cell& low = layout_.block().low;
    return {low[0] + group.cell[0][lane], low[1] + group.cell[1][lane], low[2] + group.cell[2][lane]};
  }

  static constexpr std::size_t per_link = BoundaryValues<T>::per_link(Formula::uses_second_cell);
  static constexpr std::size_t per_cell = BoundaryValues<T>::per_cell(Formula::uses_second_cell);
  /// Force of a cell's links, and its torque, which is rounded cell by cell.
  static void add(const Eigen::Vector3d& r, const std::int64_t (&force)[3], LoadSums& sums) {
    const double f[3] = {fixed_point::to_double(force[0]), fixed_point::to_double(force[1]),
                         fixed_point::to_double(force[2])};
    for (std::size_t axis = 0; axis < 3; ++axis) sums[axis] += force[axis];
    sums[3] += fixed_point::sum_from_double(r[1] * f[2] - r[2] * f[1]);
    sums[4] += fixed_point::sum_from_double(r[2] * f[0] - r[0] * f[2]);
    sums[5] += fixed_point::sum_from_double(r[0] * f[1] - r[1] * f[0]);
  }

  Formula formula_;
  const PopulationLayout& layout_;
  const BodyMap& map_;
  const ThinFilms& films_;
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
