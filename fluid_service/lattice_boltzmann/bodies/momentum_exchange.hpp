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

/// A population that a body's surface sends back, to be put in place before the bulk update.
template <class T>
struct ReflectedPopulation {
  std::int64_t location = 0;
  T value{};
};

template <class T>
struct ReflectedPopulations {
  /// By plane x, from the block's low corner, of the fluid cell.
  std::vector<std::vector<ReflectedPopulation<T>>> interior;
  std::vector<ReflectedPopulation<T>> border;  ///< to be applied after other ranks' populations have arrived

  explicit ReflectedPopulations(std::int64_t planes) : interior(static_cast<std::size_t>(planes)) {}
  void clear() {
    for (auto& plane : interior) plane.clear();
    border.clear();
  }
};

namespace momentum_exchange {

/// Larger than any population of a flow that makes sense, and a cell's links together stay within the range
/// of fixed_point::from_double; also catches NaN when negated.
constexpr double absurd_population = 1e2;

/// A body's surface is scattered over memory: without this, every population is a miss that is waited for.
constexpr std::size_t prefetch_distance = 4;

inline double along(int direction, const Eigen::Vector3d& u) {
  const auto& e = d3q19::e[direction];
  return e[0] * u[0] + e[1] * u[1] + e[2] * u[2];
}

/// Always inline: gcc drops calls of a function that does nothing but prefetch.
template <class T>
[[gnu::always_inline]] inline void prefetch(const T* populations, const PopulationLayout& layout, Placement placement,
                                            const BoundaryCell& boundary, bool second_cells) {
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    __builtin_prefetch(populations + layout.location(boundary.site, alpha, placement));
  if (!second_cells) return;
  for (std::uint32_t bits = boundary.directions & boundary.second_cells; bits != 0; bits &= bits - 1)
    __builtin_prefetch(populations + layout.entry(boundary.site, std::countr_zero(bits), placement));
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
inline double slope_between_surfaces(const BodyMap& map, const PopulationLayout& layout, const BoundaryCell& boundary,
                                     const Link& link) {
  const int alpha = link.direction;
  const auto& e = d3q19::e[alpha];
  const Cell behind = {boundary.position[0] - e[0], boundary.position[1] - e[1], boundary.position[2] - e[2]};
  const Domain& domain = map.domain();
  double e_dot_u = 0.0;
  double distance = 0.5;  // of a face
  if (domain.canonical(behind)) {
    const LatticeBody& other = map.bodies()[static_cast<std::size_t>(map.owner(layout.cell(behind)) - 1)];
    const LinkToBody seen = domain.link_to_body(other.position, boundary.position, d3q19::opposite(alpha));
    e_dot_u = -along(seen.direction, other.surface_velocity(seen.r));
    distance = wall_distance(other, seen.r, d3q19::e[seen.direction]);
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

  /// Of one body, which leaves thin films out of its loads. What the two bodies on both sides of a film leave out is
  /// opposite but for what the fluid around the film exerts on both: each receives half of the sum, so that no momentum
  /// is lost.
  /// @param cells     of the body, on this rank
  /// @param returned  mass to be given back, by the weight of the body's links
  /// @param loads     of all bodies, sums to which this rank's share is added
  /// @param kept_back likewise: momentum that left the fluid, but is not in the loads
  /// @throws SolverError if a population is not finite or absurdly large, naming the cell
  virtual void operator()(const T* populations, Placement placement, std::size_t body,
                          std::span<const BoundaryCell> cells, double returned, std::span<LoadSums> loads,
                          MomentumSums& kept_back, ReflectedPopulations<T>& reflected) const = 0;

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

  void operator()(const T* populations, Placement placement, std::size_t body_index,
                  std::span<const BoundaryCell> cells, [[maybe_unused]] double returned, std::span<LoadSums> loads,
                  MomentumSums& kept_back, ReflectedPopulations<T>& reflected) const override {
    using namespace momentum_exchange;
    const Domain& domain = map_.domain();
    const LatticeBody& body = map_.bodies()[body_index];
    const bool beside_films = films_.beside(body_index);
    LoadSums sums = loads[body_index];  // local copies, which need not be stored for every cell
    MomentumSums kept = kept_back;
    const auto add_to = [](LoadSums& sums, const Eigen::Vector3d& r, const std::int64_t(&force)[3]) {
      const double f[3] = {fixed_point::to_double(force[0]), fixed_point::to_double(force[1]),
                           fixed_point::to_double(force[2])};
      for (int axis = 0; axis < 3; ++axis) sums[static_cast<std::size_t>(axis)] += force[axis];
      sums[3] += fixed_point::sum_from_double(r[1] * f[2] - r[2] * f[1]);
      sums[4] += fixed_point::sum_from_double(r[2] * f[0] - r[0] * f[2]);
      sums[5] += fixed_point::sum_from_double(r[0] * f[1] - r[1] * f[0]);
    };
    const auto add = [&](const Eigen::Vector3d& r, const std::int64_t(&force)[3]) { add_to(sums, r, force); };
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (i + prefetch_distance < cells.size())
        prefetch(populations, layout_, placement, cells[i + prefetch_distance], Formula::uses_second_cell);
      const BoundaryCell& boundary = cells[i];
      const Populations f = layout_.gather(populations, boundary.site, placement);
      const Moments<double> m = moments(f);  // of the same bits for a cell and its mirror image
      const Eigen::Vector3d momentum = m.momentum_vector();
      std::int64_t kept_of_cell[3] = {0, 0, 0};
      const auto plane = static_cast<std::size_t>(boundary.position[0] - layout_.block().low[0]);
      auto& target = boundary.border ? reflected.border : reflected.interior[plane];
      // The link as the body sees it: from r in direction `seen`.
      const auto reflect = [&](int alpha, int seen, const Eigen::Vector3d& r, const Eigen::Vector3d& u,
                               std::int64_t(&force)[3]) {
        const auto& e = d3q19::e[seen];
        Link link{.direction = alpha,
                  .leaving = f[static_cast<std::size_t>(alpha)],
                  .density = 1.0 + m.excess_density,
                  .e_dot_u_w = along(seen, u),
                  .inward = f[static_cast<std::size_t>(d3q19::opposite(alpha))],
                  .e_dot_j = along(alpha, momentum)};
        if constexpr (Formula::uses_wall_distance) link.wall_distance = wall_distance(body, r, e);
        double exact = returning(populations, placement, boundary, link);
        if constexpr (Formula::conserving) exact += d3q19::weight(alpha) * returned;
        const T stored = static_cast<T>(exact);
        const double exchanged = link.leaving + static_cast<double>(stored);
        if (!(std::abs(exchanged) < absurd_population)) throw_diverged(boundary.position);
        ThinFilms::Film film;
        if (beside_films) film = films_.film(body_index, r + link.wall_distance * Eigen::Vector3d(e[0], e[1], e[2]));
        const std::int64_t fixed = fixed_point::from_double(film.resolved * exchanged);
        for (int axis = 0; axis < 3; ++axis) force[axis] += e[axis] * fixed;
        if (film.resolved < 1.0) {
          const std::int64_t unresolved = fixed_point::from_double(exchanged) - fixed;
          const std::int64_t half = unresolved / 2;
          std::int64_t on_other[3] = {0, 0, 0};
          for (int axis = 0; axis < 3; ++axis) {
            if (film.other < 0) {
              kept_of_cell[axis] += e[axis] * unresolved;
            } else {
              force[axis] += e[axis] * (unresolved - half);
              on_other[axis] = e[axis] * half;
            }
          }
          if (film.other == static_cast<int>(body_index))
            add(r - film.other_centre, on_other);  // through a periodic face
          else if (film.other >= 0)
            add_to(loads[static_cast<std::size_t>(film.other)], r - film.other_centre, on_other);
        }
        if constexpr (Formula::conserving) {
          const double absorbed = link.leaving - static_cast<double>(stored);
          for (int axis = 0; axis < 3; ++axis) {
            const std::int64_t of_absorbed = fixed_point::from_double(film.resolved * absorbed * u[axis]);
            force[axis] -= of_absorbed;
            kept_of_cell[axis] += of_absorbed;
          }
          sums[mass_component] += fixed_point::from_double(absorbed);
          sums[weight_component] += fixed_point::from_double(d3q19::weight(alpha));
        }
        // The population that leaves the solid cell x_f + e_α towards x_f.
        target.push_back({layout_.entry(boundary.site, d3q19::opposite(alpha), placement), stored});
      };
      const Eigen::Vector3d r = domain.from_position(body.position, boundary.position);
      const Eigen::Vector3d u = body.surface_velocity(r);
      const std::uint32_t to_images = domain.links_to_images(body.position, r, boundary.position, boundary.directions);
      std::int64_t force[3] = {0, 0, 0};
      for (std::uint32_t bits = boundary.directions & ~to_images; bits != 0; bits &= bits - 1)
        reflect(std::countr_zero(bits), std::countr_zero(bits), r, u, force);
      add(r, force);
      for (std::uint32_t bits = to_images; bits != 0; bits &= bits - 1) {
        const int alpha = std::countr_zero(bits);
        const LinkToBody link = domain.link_to_body(body.position, boundary.position, alpha);
        std::int64_t on_image[3] = {0, 0, 0};
        reflect(alpha, link.direction, link.r, body.surface_velocity(link.r), on_image);
        add(link.r, on_image);
      }
      for (std::size_t axis = 0; axis < 3; ++axis) kept[axis] += kept_of_cell[axis];
    }
    loads[body_index] = sums;
    kept_back = kept;
  }

 private:
  /// f_ᾱ(x_f). A formula that needs a second cell where there is none gives way to bounce-back from half-way along the
  /// link, where the fluid between the two surfaces moves with
  ///   e_α·u_w + (1/2 − q) d(e_α·u)/ds
  double returning(const T* populations, Placement placement, const BoundaryCell& boundary, Link& link) const {
    if constexpr (Formula::uses_second_cell) {
      if (((boundary.second_cells >> link.direction) & 1U) == 0) {
        Link half_way = link;
        half_way.e_dot_u_w +=
            (0.5 - link.wall_distance) * momentum_exchange::slope_between_surfaces(map_, layout_, boundary, link);
        return BounceBack().returning(half_way);
      }
      link.behind = populations[layout_.entry(boundary.site, link.direction, placement)];  // where it enters x_f
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
