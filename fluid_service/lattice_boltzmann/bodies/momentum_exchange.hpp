#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/boundary_links.hpp"
#include "lattice_boltzmann/bodies/link_formula.hpp"
#include "lattice_boltzmann/bodies/thin_films.hpp"
#include "lattice_boltzmann/kernel/collision.hpp"
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

inline double along(int direction, const Eigen::Vector3d& u) {
  const auto& e = d3q19::velocity[static_cast<std::size_t>(direction)];
  return e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
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
inline double slope_between_surfaces(const BodyMap& map, const PopulationLayout& layout, const Cell& at,
                                     const Link& link) {
  const int alpha = link.direction;
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

  /// Of one body, which leaves thin films out of its loads.
  /// @param surface   of the body, on this rank, with the populations after the bulk update; f_ᾱ replaces f̃_α
  /// @param returned  mass to be given back, by the weight of the body's links
  /// @param loads     sums to which this rank's share is added
  /// @param kept_back likewise: momentum that left the fluid, but is not in the loads
  /// @throws SolverError if a population is not finite or absurdly large, naming the cell
  virtual void operator()(const T* populations, Placement placement, std::size_t body, BodySurface<T>& surface,
                          double returned, LoadSums& loads, MomentumSums& kept_back) const = 0;

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
        films_(films) {}

  void operator()(const T* populations, Placement placement, std::size_t body_index, BodySurface<T>& surface,
                  double returned, LoadSums& loads, MomentumSums& kept_back) const override {
    using namespace momentum_exchange;
    const Domain& domain = map_.domain();
    const LatticeBody& body = map_.bodies()[body_index];
    const bool beside_films = films_.beside(body_index);
    LoadSums sums = loads;  // local copies, which need not be stored for every cell
    MomentumSums kept = kept_back;
    for (std::size_t i = 0; i < surface.cells.size(); ++i) {
      const BoundaryCell& cell = surface.cells[i];
      if (cell.directions == 0) continue;
      if constexpr (Formula::uses_second_cell)
        prefetch_second_cells(populations, placement, surface, i + prefetch_distance);
      const Cell at = position_of(cell);
      std::int64_t kept_of_cell[3] = {0, 0, 0};
      // One link, as the body sees it from r in direction `seen`, the n-th of the cell.
      const auto reflect = [&](int n, int alpha, int seen, const Eigen::Vector3d& r, const Eigen::Vector3d& u,
                               std::int64_t(&force)[3]) __attribute__((always_inline)) {
        const auto place = cell.first_link + static_cast<std::size_t>(n);
        const auto& e = d3q19::e[static_cast<std::size_t>(seen)];
        T& population = surface.populations[place];
        Link link{.direction = alpha,
                  .leaving = static_cast<double>(population),
                  .density = 1.0 + surface.excess_density[i],
                  .e_dot_u_w = along(seen, u)};
        if constexpr (Formula::uses_second_cell) {
          link.inward = static_cast<double>(surface.inward[place]);
          link.e_dot_j = along(alpha, surface.momentum[i]);
        }
        if constexpr (Formula::uses_wall_distance) link.wall_distance = wall_distance(body, r, seen);
        double exact = returning(populations, placement, cell, at, link);
        if constexpr (Formula::conserving) exact += d3q19::weight(alpha) * returned;
        population = static_cast<T>(exact);
        const auto stored = static_cast<double>(population);
        const double exchanged = link.leaving + stored;
        if (!(std::abs(exchanged) < absurd_population)) throw_diverged(at);
        double resolved = 1.0;
        if (beside_films)
          resolved = films_.resolved_share(body_index, r + link.wall_distance * Eigen::Vector3d(e[0], e[1], e[2]));
        const std::int64_t fixed = fixed_point::from_double(resolved * exchanged);
        for (int axis = 0; axis < 3; ++axis) force[axis] += e[axis] * fixed;
        if (beside_films) {
          const std::int64_t unresolved = fixed_point::from_double(exchanged) - fixed;
          for (int axis = 0; axis < 3; ++axis) kept_of_cell[axis] += e[axis] * unresolved;
        }
        if constexpr (Formula::conserving) {
          const double absorbed = link.leaving - stored;
          for (int axis = 0; axis < 3; ++axis) {
            const std::int64_t of_absorbed = fixed_point::from_double(resolved * absorbed * u[axis]);
            force[axis] -= of_absorbed;
            kept_of_cell[axis] += of_absorbed;
          }
          sums[mass_component] += fixed_point::from_double(absorbed);
          sums[weight_component] += fixed_point::from_double(d3q19::weight(alpha));
        }
      };
      const Eigen::Vector3d r = domain.from_position(body.position, at);
      const Eigen::Vector3d u = body.surface_velocity(r);
      const std::uint32_t to_images = domain.links_to_images(body.position, r, at, cell.directions);
      std::int64_t force[3] = {0, 0, 0};
      int n = 0;
      for (std::uint32_t bits = cell.directions; bits != 0; bits &= bits - 1, ++n) {
        const int alpha = std::countr_zero(bits);
        if (((to_images >> alpha) & 1U) != 0) [[unlikely]] {
          const LinkToBody link = domain.link_to_body(body.position, at, alpha);
          std::int64_t on_image[3] = {0, 0, 0};
          reflect(n, alpha, link.direction, link.r, body.surface_velocity(link.r), on_image);
          add(link.r, on_image, sums);
        } else {
          reflect(n, alpha, alpha, r, u, force);
        }
      }
      add(r, force, sums);
      if (beside_films || Formula::conserving)
        for (std::size_t axis = 0; axis < 3; ++axis) kept[axis] += kept_of_cell[axis];
    }
    loads = sums;
    kept_back = kept;
  }

 private:
  static constexpr std::size_t prefetch_distance = 4;  ///< second cells are scattered over memory

  void prefetch_second_cells(const T* populations, Placement placement, const BodySurface<T>& surface,
                             std::size_t place) const {
    if (place >= surface.cells.size()) return;
    const BoundaryCell& cell = surface.cells[place];
    for (std::uint32_t bits = cell.directions & cell.second_cells; bits != 0; bits &= bits - 1)
      __builtin_prefetch(populations +
                         layout_.entry(layout_.site(position_of(cell)), std::countr_zero(bits), placement));
  }

  [[nodiscard]] Cell position_of(const BoundaryCell& cell) const {
    const Cell& low = layout_.block().low;
    return {low[0] + cell.place[0], low[1] + cell.place[1], low[2] + cell.place[2]};
  }

  /// Force of a cell's links, and its torque, which is rounded cell by cell.
  static void add(const Eigen::Vector3d& r, const std::int64_t (&force)[3], LoadSums& sums) {
    const double f[3] = {fixed_point::to_double(force[0]), fixed_point::to_double(force[1]),
                         fixed_point::to_double(force[2])};
    for (std::size_t axis = 0; axis < 3; ++axis) sums[axis] += force[axis];
    sums[3] += fixed_point::sum_from_double(r[1] * f[2] - r[2] * f[1]);
    sums[4] += fixed_point::sum_from_double(r[2] * f[0] - r[0] * f[2]);
    sums[5] += fixed_point::sum_from_double(r[0] * f[1] - r[1] * f[0]);
  }

  /// f_ᾱ(x_f). A formula that needs a second cell where there is none gives way to bounce-back from half-way along the
  /// link, where the fluid between the two surfaces moves with
  ///   e_α·u_w + (1/2 − q) d(e_α·u)/ds
  double returning(const T* populations, Placement placement, const BoundaryCell& boundary, const Cell& at,
                   Link& link) const {
    if constexpr (Formula::uses_second_cell) {
      if (((boundary.second_cells >> link.direction) & 1U) == 0) {
        Link half_way = link;
        half_way.e_dot_u_w +=
            (0.5 - link.wall_distance) * momentum_exchange::slope_between_surfaces(map_, layout_, at, link);
        return BounceBack().returning(half_way);
      }
      link.behind = static_cast<double>(
          populations[layout_.entry(layout_.site(at), link.direction, placement)]);  // where it enters x_f
    }
    return formula_.returning(link);
  }

  Formula formula_;
  const PopulationLayout& layout_;
  const BodyMap& map_;
  const ThinFilms& films_;
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
