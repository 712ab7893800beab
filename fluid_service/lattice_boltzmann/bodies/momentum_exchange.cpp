#include "lattice_boltzmann/bodies/momentum_exchange.hpp"

#include <bit>
#include <cmath>
#include <string>

#include "contract/errors.hpp"
#include "lattice_boltzmann/bodies/link_formula.hpp"
#include "lattice_boltzmann/lattice/moments.hpp"

namespace copepod::fluid {

namespace {

/// Larger than any population of a flow that makes sense, and a cell's links together stay within the range
/// of fixed_point::from_double; also catches NaN when negated.
constexpr double absurd_population = 1e2;

/// A body's surface is scattered over memory: without this, every population is a miss that is waited for.
constexpr std::size_t prefetch_distance = 8;

template <class T>
void prefetch(const T* populations, const PopulationLayout& layout, Placement placement,
              const BoundaryCell& boundary) {
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    __builtin_prefetch(populations + layout.location(boundary.site, alpha, placement));
}

[[noreturn]] void throw_diverged(const Cell& cell) {
  throw SolverError(
      "the flow diverged beside a body at cell (" + std::to_string(cell[0]) + ", " + std::to_string(cell[1]) +
      ", " + std::to_string(cell[2]) +
      ") (a population is not finite or far too large). Use a larger relaxation time, weaker forces, or "
      "coupling.load_averaging: two_step for light bodies.");
}

template <class Formula, class T>
void exchange_momentum(const T* populations, const PopulationLayout& layout, Placement placement,
                       const Domain& domain, const LatticeBody& body, std::span<const BoundaryCell> cells,
                       LoadSums& loads, ReflectedPopulations<T>& reflected) {
  LoadSums sums = loads;  // a local copy, which need not be stored for every cell
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i + prefetch_distance < cells.size())
      prefetch(populations, layout, placement, cells[i + prefetch_distance]);
    const BoundaryCell& boundary = cells[i];
    const Eigen::Vector3d r = domain.from_position(body.position, boundary.position);
    const Eigen::Vector3d u = body.surface_velocity(r);
    const double density = 1.0 + excess_density_of_cell(populations, layout, boundary.site, placement);
    const auto plane = static_cast<std::size_t>(boundary.position[0] - layout.block().low[0]);
    auto& target = boundary.border ? reflected.border : reflected.interior[plane];
    std::int64_t force[3] = {0, 0, 0};
    for (std::uint32_t bits = boundary.directions; bits != 0; bits &= bits - 1) {
      const int alpha = std::countr_zero(bits);
      const auto& e = d3q19::e[alpha];
      Link link{.direction = alpha,
                .leaving = populations[layout.location(boundary.site, alpha, placement)],
                .density = density,
                .e_dot_u_w = e[0] * u[0] + e[1] * u[1] + e[2] * u[2]};
      if constexpr (Formula::uses_wall_distance) link.wall_distance = wall_distance(body, r, e);
      const T returning = static_cast<T>(Formula::returning(link));
      const double exchanged = link.leaving + static_cast<double>(returning);
      if (!(std::abs(exchanged) < absurd_population)) throw_diverged(boundary.position);
      const std::int64_t fixed = fixed_point::from_double(exchanged);
      for (int axis = 0; axis < 3; ++axis) force[axis] += e[axis] * fixed;
      // The population that leaves the solid cell x_f + e_α towards x_f.
      target.push_back({layout.entry(boundary.site, d3q19::opposite(alpha), placement), returning});
    }
    const double f[3] = {fixed_point::to_double(force[0]), fixed_point::to_double(force[1]),
                         fixed_point::to_double(force[2])};
    for (int axis = 0; axis < 3; ++axis) sums[static_cast<std::size_t>(axis)] += force[axis];
    sums[3] += fixed_point::sum_from_double(r[1] * f[2] - r[2] * f[1]);
    sums[4] += fixed_point::sum_from_double(r[2] * f[0] - r[0] * f[2]);
    sums[5] += fixed_point::sum_from_double(r[0] * f[1] - r[1] * f[0]);
  }
  loads = sums;
}

}  // namespace

template <class T>
MomentumExchange<T> choose_momentum_exchange(MovingBoundary formula) {
  switch (formula) {
    case MovingBoundary::bounce_back:
      return &exchange_momentum<BounceBack, T>;
  }
  throw CaseError("unknown moving_boundary (a newer coupler?). Use bounce_back.");
}

template MomentumExchange<float> choose_momentum_exchange(MovingBoundary);
template MomentumExchange<double> choose_momentum_exchange(MovingBoundary);

}  // namespace copepod::fluid
