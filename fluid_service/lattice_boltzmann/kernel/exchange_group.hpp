#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <tuple>
#include <type_traits>

#include "lattice_boltzmann/kernel/film.hpp"
#include "lattice_boltzmann/kernel/link_formula.hpp"
#include "lattice_boltzmann/kernel/packs.hpp"
#include "lattice_boltzmann/kernel/stream_collide.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"

// Momentum exchange of eight boundary cells of a body at once: what MomentumExchange does for most cells, with the
// same bits. Compiled once per instruction set, like the bulk update, and hence without Eigen.

namespace copepod::fluid {

/// A body and where its boundary cells are, lattice units.
struct BodyInBlock {
  double first_cell[3]{};  ///< centre of the block's first cell
  double position[3]{};
  double image[3]{};  ///< what leads from its position to the image that the block sees
  double velocity[3]{};
  double angular_velocity[3]{};
  double radius = 0.0;           ///< of the sphere, or of a ball around the position that contains another body
  double returned = 0.0;         ///< mass to be given back, by the weight of the links
  const double* form = nullptr;  ///< of an ellipsoid r·A r = 1: A
  const double* wall_distances = nullptr;  ///< of other bodies, by group, link of a cell, and lane
  FilmsBeside* films = nullptr;
  static constexpr std::size_t distances_per_group = (d3q19::directions - 1) * surface_lanes;
};

/// Sums by lane, as integers: LoadSums and the momentum kept back.
struct LaneSums {
  static constexpr std::size_t components = 11;
  std::array<Lanes<std::int64_t>, components> sums{};

  /// Rounds a number below 2 to a multiple of 2⁻⁵⁰, as fixed_point::from_double does: in [4, 8) these are the doubles.
  static constexpr double rounder = 6.0;
  static constexpr double limit = 1.9;
  static constexpr std::size_t most_groups = 4096;  ///< of which 64 bits surely hold the sums: 2¹² times 2⁵¹
};

/// Momentum exchange of the cells of some groups with a body. Some of those that follow are asked for ahead.
/// @param groups  `count` of them, and as many more as groups_ahead has it
/// @return how many were computed: all, or those before the first one whose numbers are too large for exact sums, or,
///         where the formula uses second cells, not all of whose second cells are fluid
template <class Formula, class T>
using ExchangeGroupsBy = std::size_t (*)(const Formula& formula, const BodyInBlock& body,
                                         const CellGroup* const* groups, std::size_t count, BoundaryValues<T>& values,
                                         LaneSums& sums);

/// Groups are in order body by body only, and the rows of a body are scattered over memory: values are asked for this
/// many groups before they are needed, groups themselves twice as many.
inline constexpr std::size_t groups_ahead = 4;

// Always inline: gcc drops calls of functions that only prefetch.
template <std::size_t per_link, std::size_t per_cell, class T>
[[gnu::always_inline]] inline void prefetch_ahead(const CellGroup* const* groups, const BoundaryValues<T>& values) {
  const char* const bytes = reinterpret_cast<const char*>(groups[2 * groups_ahead]);
  for (std::size_t i = 0; i < sizeof(CellGroup); i += 64) __builtin_prefetch(bytes + i);
  const CellGroup& next = *groups[groups_ahead];
  for (std::size_t lane = 0; lane < surface_lanes; ++lane) {
    const T* const links = values.by_link.data() + per_link * next.first_link[lane];
    __builtin_prefetch(links, 1);
    if (per_link > 1) __builtin_prefetch(links + 64 / sizeof(T), 1);
    __builtin_prefetch(values.by_cell.data() + per_cell * next.moments[lane]);
  }
}

template <class T>
using ExchangeGroups = std::tuple<ExchangeGroupsBy<BounceBack, T>, ExchangeGroupsBy<Interpolated, T>,
                                  ExchangeGroupsBy<CentralLinear, T>, ExchangeGroupsBy<Parabolic, T>>;

/// One build of the kernels; empty if this machine cannot run it.
template <class T>
struct Kernels {
  const char* instruction_set = "";
  StreamCollide<T> stream_collide = nullptr;
  ExchangeGroups<T> exchange_groups;
};

/// The fastest build that this machine can run.
template <class T>
Kernels<T> choose_kernels();

/// A particular build, for tests and benchmarks.
template <class T>
Kernels<T> baseline_kernels();
template <class T>
Kernels<T> avx2_kernels();
template <class T>
Kernels<T> avx512_kernels();

template <class Isa, class Formula, class T>
struct ExchangeGroupLoop {
  static constexpr std::size_t width = Isa::vector_bytes / sizeof(double);
  template <class U>
  struct PackOf {  // a member, which gcc 12 takes as an argument of templates; it mistakes Pack<U, width> for U
    using Type [[gnu::vector_size(sizeof(U) * width)]] = U;
  };
  using V = typename PackOf<double>::Type;
  using TLanes = typename PackOf<T>::Type;
  using Integers = typename PackOf<std::int64_t>::Type;
  template <bool in_films>
  static constexpr std::size_t components = Formula::conserving || in_films ? LaneSums::components : 6;
  using Values = BoundaryValues<T>;
  static constexpr std::size_t per_link = Values::per_link(Formula::uses_second_cell);
  static constexpr std::size_t per_cell = Values::per_cell(Formula::uses_second_cell);

  /// What a group becomes if its numbers turn out to be small.
  struct Outcome {
    std::array<Lanes<T>, d3q19::directions> returning;  ///< by link
    std::array<Lanes<double>, LaneSums::components> added;
  };

  static std::size_t run(const Formula& formula, const BodyInBlock& body, const CellGroup* const* groups,
                         std::size_t count, BoundaryValues<T>& values, LaneSums& sums) {
    if (Formula::conserving && !is_slow(body)) return 0;
    for (std::size_t g = 0; g < count; ++g) {
      prefetch_ahead<per_link, per_cell>(groups + g, values);
      const bool done = find_films(body, *groups[g]) ? exchange<true>(formula, body, g, *groups[g], values, sums)
                                                     : exchange<false>(formula, body, g, *groups[g], values, sums);
      if (!done) return g;
    }
    return count;
  }

 private:
  template <bool in_films>
  [[gnu::always_inline]] static bool exchange(const Formula& formula, const BodyInBlock& body, std::size_t g,
                                              const CellGroup& group, BoundaryValues<T>& values, LaneSums& sums) {
    Outcome outcome;  // NOLINT(cppcoreguidelines-pro-type-member-init): written before it is read, and large
    for (std::size_t lane = 0; lane < surface_lanes; lane += width)
      if (!exchange<in_films>(formula, body, g, group, values, lane, outcome)) return false;
    keep<in_films>(body, outcome, group, values, sums);
    return true;
  }

  static constexpr std::int64_t bits_of_rounder = __builtin_bit_cast(std::int64_t, LaneSums::rounder);
  /// Directions along the axes, and those with a positive (sign 1) or negative component along one.
  static constexpr std::int64_t axes = 0x7e;
  static constexpr std::int64_t along(std::size_t axis, int sign) {
    std::int64_t result = 0;
    for (std::size_t alpha = 0; alpha < d3q19::directions; ++alpha)
      if (d3q19::e[alpha][axis] == sign) result |= 1 << alpha;
    return result;
  }
  static_assert(2.0 * d3q19::weight(7) == d3q19::weight(1));

  /// Whether no cell beside the body, or its surface, moves by a cell or more in a step.
  static bool is_slow(const BodyInBlock& body) {
    const auto length = [](const double(&x)[3]) { return __builtin_sqrt(x[0] * x[0] + x[1] * x[1] + x[2] * x[2]); };
    return length(body.velocity) + (body.radius + 2.0) * length(body.angular_velocity) < 1.0;
  }

  template <bool in_films>
  [[gnu::always_inline]] static void keep(const BodyInBlock& body, const Outcome& outcome, const CellGroup& group,
                                          BoundaryValues<T>& values, LaneSums& sums) {
    std::array<T*, surface_lanes> returning{};
    for (std::size_t lane = 0; lane < surface_lanes; ++lane)
      returning[lane] = values.by_link.data() + per_link * group.first_link[lane] + Values::crossing;
    for (std::uint32_t j = 0; j < group.links; ++j)
      for (std::size_t lane = 0; lane < surface_lanes; ++lane)
        returning[lane][per_link * j] = outcome.returning[j][lane];
    for (std::size_t c = 0; c < components<in_films>; ++c) add_up(outcome.added[c], sums.sums[c]);
    if constexpr (!in_films) return;
    for (FilmBeside& film : body.films->surfaces)
      for (std::size_t c = 0; film.is_near && c < FilmBeside::components; ++c) add_up(film.added[c], film.sums[c]);
  }

  [[gnu::always_inline]] static void add_up(const Lanes<double>& added, Lanes<std::int64_t>& sums) {
    for (std::size_t lane = 0; lane < surface_lanes; lane += width) {
      const V shifted = load<V>(added.data() + lane) + LaneSums::rounder;
      Integers bits;
      std::memcpy(&bits, &shifted, sizeof(bits));
      const Integers sum = load<Integers>(sums.data() + lane) + (bits - bits_of_rounder);
      std::memcpy(sums.data() + lane, &sum, sizeof(sum));
    }
  }

  template <class Vector, class U>
  [[gnu::always_inline]] static Vector load(const U* values) {
    if constexpr (std::is_integral_v<U> && sizeof(U) == 4) {  // which gcc 12 converts by halves otherwise
      std::remove_cvref_t<decltype(Vector{}[0])> lanes[width];
      for (std::size_t l = 0; l < width; ++l) lanes[l] = values[l];
      Vector result;
      std::memcpy(&result, lanes, sizeof(result));
      return result;
    } else {
      typename PackOf<U>::Type packed;
      std::memcpy(&packed, values, sizeof(packed));
      return __builtin_convertvector(packed, Vector);
    }
  }

  /// One of `count` values of each place.
  template <std::size_t count, class U>
  [[gnu::always_inline]] static V gather(const U* values, const std::uint32_t* places) {
    U lanes[width];
    for (std::size_t l = 0; l < width; ++l) lanes[l] = values[count * places[l]];
    return load<V>(lanes);
  }

  /// e_α of one link per lane. Where selecting costs nothing, as with AVX-512, products with it are additions under a
  /// mask; no sum is −0 either way.
  struct Direction {
    static constexpr bool by_masks = Isa::vector_bytes == 64;
    Integers forward[3];   ///< where a component is 1
    Integers backward[3];  ///< where it is −1
    V e[3];

    [[gnu::always_inline]] explicit Direction(const Integers& bit) {
      const V zero{};
      for (std::size_t a = 0; a < 3; ++a) {
        forward[a] = (bit & along(a, 1)) != 0;
        backward[a] = (bit & along(a, -1)) != 0;
        e[a] = backward[a] ? zero - 1.0 : (forward[a] ? zero + 1.0 : zero);
      }
    }
    /// sum + e_a x
    [[gnu::always_inline]] V add(std::size_t a, const V& sum, const V& x) const {
      if constexpr (!by_masks) return sum + e[a] * x;
      const V added = forward[a] ? sum + x : sum;
      return backward[a] ? added - x : added;
    }
    /// e_α·x
    [[gnu::always_inline]] V dot(const V (&x)[3]) const { return add(2, add(1, add(0, V{}, x[0]), x[1]), x[2]); }
  };

  [[gnu::always_inline]] static V rounded(const V& x) { return (x + LaneSums::rounder) - LaneSums::rounder; }

  /// From the body's position to cells.
  [[gnu::always_inline]] static void place(const BodyInBlock& body, const CellGroup& group, std::size_t lane,
                                           V (&r)[3]) {
    for (std::size_t a = 0; a < 3; ++a)
      r[a] = (load<V>(group.cell[a].data() + lane) + body.first_cell[a]) - body.position[a] - body.image[a];
  }

  /// Whether links of a group may end in films; marks these.
  static bool find_films(const BodyInBlock& body, const CellGroup& group) {
    constexpr double longer_than_links = 1.5;
    bool any = false;
    for (FilmBeside& film : body.films->surfaces) {
      film.is_near = false;
      const double reach = (film.far_m - film.distance_of_centre_m) / body.films->cell_m + longer_than_links;
      for (std::size_t lane = 0; lane < surface_lanes; lane += width) {
        V r[3];
        place(body, group, lane, r);
        const Integers free = load<Integers>(group.directions.data() + lane) == 0;
        film.is_near |= !all(free | (dot(film.normal, r) >= reach));
      }
      if (film.is_near) film.added = {};
      any |= film.is_near;
    }
    return any;
  }

  /// Half of integers, multiples of 2⁻⁵⁰, without the fraction.
  [[gnu::always_inline]] static V half_of(const V& x) {
    const V half = 0.5 * x;
    return rounded(half > 0.0 ? half - 0x1p-52 : half + 0x1p-52);
  }

  /// Adds the force `half` e of links, and its torque, to what acts on the other side of a film.
  /// @return the square of the torque
  [[gnu::always_inline]] static V add_to_other(FilmBeside& film, double cell_m, std::size_t lane, const V (&r)[3],
                                               const Direction& direction, const V& half) {
    V square{}, force[3], arm[3];
    for (std::size_t a = 0; a < 3; ++a) {
      force[a] = direction.add(a, V{}, half);
      arm[a] = r[a] - film.centre_m[a] / cell_m;
    }
    const auto add = [&](std::size_t component, const V& value) __attribute__((always_inline)) {
      const V sum = load<V>(film.added[component].data() + lane) + value;
      std::memcpy(film.added[component].data() + lane, &sum, sizeof(sum));
    };
    for (std::size_t a = 0; a < 3; ++a) {
      const V torque = cross(arm, force, a);
      square = square + torque * torque;
      add(a, force[a]);
      add(3 + a, rounded(torque));
    }
    return square;
  }

  /// Where links cross the sphere or ellipsoid, as first_root has it.
  [[gnu::always_inline]] static V wall_distance(const V& half_linear, const V& square, const V& constant) {
    const V linear = -half_linear;
    const V discriminant = linear * linear - square * constant;
    const V q = constant / (linear + square_root(discriminant));
    const Integers misses = (linear <= 0.0) | (constant < 0.0) | (discriminant < 0.0) | ~(q < 1.0);
    return misses ? V{} + 1.0 : q;
  }

  /// Of the lanes from `lane` on in group number `g`.
  /// @tparam in_films  as SingleLinks has it, for the films that are marked
  template <bool in_films>
  [[gnu::always_inline]] static bool exchange(const Formula& formula, const BodyInBlock& body, std::size_t g,
                                              const CellGroup& group, const BoundaryValues<T>& values, std::size_t lane,
                                              Outcome& outcome) {
    // Where the squares of a cell's numbers, at most 18 of either kind, add up to less, each kind adds up to √18 · 0.2
    // at most: exactly, without a rounding of sums, and below the limit with 1 that absorbed mass carries.
    constexpr double small = 0.2;
    V r[3];
    place(body, group, lane, r);
    const double* w = body.angular_velocity;
    const V u[3] = {body.velocity[0] + cross(w, r, 0), body.velocity[1] + cross(w, r, 1),
                    body.velocity[2] + cross(w, r, 2)};
    V A_r[3] = {r[0], r[1], r[2]};  // of an ellipsoid; of a sphere A is 1
    if (body.form != nullptr) multiply(body.form, r, A_r);
    const V constant = dot(r, A_r) - (body.form != nullptr ? 1.0 : body.radius * body.radius);
    const double* distances = body.wall_distances;
    if (distances != nullptr) distances += BodyInBlock::distances_per_group * g + lane;
    V force[3] = {};
    V mass = {};
    V arm[3] = {};
    V weights = {};
    V exchanged_squares = {};
    [[maybe_unused]] V resolved_mass = {};
    [[maybe_unused]] V left_out[3] = {};
    [[maybe_unused]] V torque_squares = {};
    auto left = load<Integers>(group.directions.data() + lane);
    Link<V> link;
    link.wall_distance = V{} + 0.5;
    const std::uint32_t* const first = group.first_link.data() + lane;
    const std::uint32_t* const moments = group.moments.data() + lane;
    const V excess = gather<per_cell>(values.by_cell.data() + Values::excess_density, moments);
    constexpr double not_squeezed = 0.99 * largest_excess_density;  // squares are rounded: rather one by one
    Integers good = excess * excess < not_squeezed * not_squeezed;
    if constexpr (Formula::uses_second_cell) good &= (left & ~load<Integers>(group.second_cells.data() + lane)) == 0;
    link.density = 1.0 + excess;
    [[maybe_unused]] V momentum[3];
    if constexpr (Formula::uses_second_cell)
      for (std::size_t a = 0; a < 3; ++a)
        momentum[a] = gather<per_cell>(values.by_cell.data() + Values::momentum + a, moments);
    for (std::uint32_t j = 0; j < group.links; ++j) {
      const Integers bit = left & -left;
      left ^= bit;
      const Direction direction(bit);
      std::ranges::copy(direction.e, link.e);
      const V zero{};
      link.weight = bit != 0 ? zero + d3q19::weight(7) : zero;
      link.weight = (bit & axes) != 0 ? zero + d3q19::weight(1) : link.weight;
      const T* const of_first = values.by_link.data() + per_link * j;
      link.leaving = gather<per_link>(of_first + Values::crossing, first);
      link.e_dot_u_w = direction.dot(u);
      if constexpr (Formula::uses_second_cell) {
        link.inward = gather<per_link>(of_first + Values::inward, first);
        link.behind = gather<per_link>(of_first + Values::behind, first);
        link.e_dot_j = direction.dot(momentum);
      }
      if constexpr (Formula::uses_wall_distance) {
        V e_A_e = (bit & axes) != 0 ? zero + 1.0 : zero + 2.0;
        if (body.form != nullptr) {
          V A_e[3];
          multiply(body.form, direction.e, A_e);
          e_A_e = direction.dot(A_e);
        }
        link.wall_distance = distances != nullptr ? load<V>(distances + surface_lanes * j)
                                                  : wall_distance(direction.dot(A_r), e_A_e, constant);
      }
      V exact = formula.template returning<V>(link);
      if constexpr (Formula::conserving) exact = exact + link.weight * body.returned;
      const TLanes stored = __builtin_convertvector(exact, TLanes);
      std::memcpy(outcome.returning[j].data() + lane, &stored, sizeof(stored));
      const V returning = __builtin_convertvector(stored, V);
      const V exchanged = link.leaving + returning;
      exchanged_squares = exchanged_squares + exchanged * exchanged;
      V fixed = rounded(exchanged);
      [[maybe_unused]] V resolved = zero + 1.0;
      if constexpr (in_films) {
        const Film<V> film(*body.films, r, link.wall_distance, link.e);
        resolved = film.resolved;
        const V all_of_it = fixed;
        fixed = rounded(resolved * exchanged);
        const V unresolved = all_of_it - fixed;
        const std::size_t count = all(film.number < 0) ? 0 : body.films->surfaces.size();
        for (std::size_t i = 0; i < count; ++i) {
          FilmBeside& beside = body.films->surfaces[i];
          const Integers here = film.number == static_cast<std::int64_t>(i);
          if (!beside.is_near || all(~here)) continue;
          const V missing = here ? unresolved : zero;
          if (beside.other < 0) {
            for (std::size_t a = 0; a < 3; ++a) left_out[a] = direction.add(a, left_out[a], missing);
            continue;
          }
          const V half = half_of(missing);
          fixed = fixed + (missing - half);
          torque_squares = torque_squares + add_to_other(beside, body.films->cell_m, lane, r, direction, half);
        }
      }
      for (std::size_t a = 0; a < 3; ++a) force[a] = direction.add(a, force[a], fixed);
      if constexpr (Formula::conserving) {
        const V absorbed = link.leaving - returning;
        exchanged_squares = exchanged_squares + absorbed * absorbed;
        V carried = absorbed;
        if constexpr (in_films) carried = resolved * absorbed;
        const V at_surface = rounded(carried * link.wall_distance);
        if constexpr (in_films) resolved_mass = resolved_mass + rounded(carried);
        for (std::size_t a = 0; a < 3; ++a) arm[a] = direction.add(a, arm[a], at_surface);
        mass = mass + rounded(absorbed);
        weights = weights + rounded(link.weight);
      }
    }
    V kept[3] = {};
    if constexpr (Formula::conserving) {
      const V& moved = in_films ? resolved_mass : mass;
      for (std::size_t a = 0; a < 3; ++a) kept[a] = moved * u[a] + cross(w, arm, a);
      for (std::size_t a = 0; a < 3; ++a) force[a] = force[a] - (kept[a] = rounded(kept[a]));
    }
    V torque[3] = {cross(r, force, 0), cross(r, force, 1), cross(r, force, 2)};
    if constexpr (Formula::conserving)
      for (std::size_t a = 0; a < 3; ++a) torque[a] = torque[a] - cross(arm, u, a);
    if constexpr (in_films) {
      for (std::size_t a = 0; a < 3; ++a) kept[a] = kept[a] + left_out[a];
      good &= torque_squares < LaneSums::limit * LaneSums::limit / d3q19::directions;
    }
    good &= (exchanged_squares < small * small) & (dot(torque, torque) < LaneSums::limit * LaneSums::limit);
    const V added[] = {force[0], force[1], force[2], torque[0], torque[1], torque[2],
                       mass,     weights,  kept[0],  kept[1],   kept[2]};
    for (std::size_t c = 0; c < components<in_films>; ++c)
      std::memcpy(outcome.added[c].data() + lane, &added[c], sizeof(V));
    return all(good);
  }
};

/// For every formula.
template <class Isa, class T>
Kernels<T> kernels_for(const char* instruction_set) {
  return {instruction_set,
          &StreamCollideLoop<Isa, T>::run,
          {&ExchangeGroupLoop<Isa, BounceBack, T>::run, &ExchangeGroupLoop<Isa, Interpolated, T>::run,
           &ExchangeGroupLoop<Isa, CentralLinear, T>::run, &ExchangeGroupLoop<Isa, Parabolic, T>::run}};
}

}  // namespace copepod::fluid
