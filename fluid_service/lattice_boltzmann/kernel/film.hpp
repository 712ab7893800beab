#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <vector>

#include "lattice_boltzmann/kernel/packs.hpp"
#include "lattice_boltzmann/kernel/surface_cells.hpp"

// Films between a body and what is near it, where links cross the body's surface (V: a link, or one per lane).

namespace copepod::fluid {

/// A NearSurface of a body, and what links that end in films beside it add.
struct FilmBeside {
  int other = -1;                          ///< body whose loads take half of what the film leaves out; −1: none
  const double* centre_m = nullptr;        ///< of another body, from the centre of this one; null: a wall
  const double* half_m = nullptr;          ///< of its core
  const double* inverse_per_m2 = nullptr;  ///< S⁻¹ of an ellipsoid, else null
  double radius_m = 0.0;
  const double* normal = nullptr;
  double distance_of_centre_m = 0.0;
  double far_m = 0.0;    ///< no film so far from the plane with this normal that touches the surface
  bool is_near = false;  ///< of the group of cells that is computed by lanes
  static constexpr std::size_t components = 6;
  std::array<Lanes<double>, components> added{};       ///< force and torque on `other`, by that group
  std::array<Lanes<std::int64_t>, components> sums{};  ///< by all groups, as in LaneSums
};

/// All of a body.
struct FilmsBeside {
  std::vector<FilmBeside> surfaces{};
  double cell_m = 0.0;
  double low_m = 0.0, high_m = 0.0;  ///< as FilmRange has them
};

/// From a surface to points, relative to the body's centre, as NearSurface::from has it.
template <class V>
[[gnu::always_inline]] inline V thickness_m(const FilmBeside& film, const V (&point_m)[3]) {
  if (film.centre_m == nullptr) return film.distance_of_centre_m + dot(film.normal, point_m);
  V p[3] = {point_m[0] - film.centre_m[0], point_m[1] - film.centre_m[1], point_m[2] - film.centre_m[2]};
  if (film.inverse_per_m2 != nullptr) {
    V along[3];
    multiply(film.inverse_per_m2, p, along);
    const double* const last = film.inverse_per_m2 + 6;
    along[2] = last[0] * p[0] + (last[1] * p[1] + last[2] * p[2]);  // in the order that digests depend on
    const V s = square_root(dot(p, along));
    return (s - 1.0) * s / square_root(dot(along, along));
  }
  const double* const half = film.half_m;
  if (const double square = dot(half, half); square > 0.0) {
    V nearest = dot(half, p) / square;
    nearest = nearest < -1.0 ? V{} - 1.0 : (nearest > 1.0 ? V{} + 1.0 : nearest);
    for (std::size_t a = 0; a < 3; ++a) p[a] = p[a] - nearest * half[a];
  }
  return square_root(dot(p, p)) - film.radius_m;
}

/// The thinnest film at a point of the body's surface.
template <class V>
struct Film {
  static constexpr bool by_lanes = !std::is_floating_point_v<V>;
  using Numbers = std::conditional_t<by_lanes, decltype(V{} < V{}), std::int64_t>;
  V resolved = V{} + 1.0;          ///< part of what acts there that belongs to the body's loads
  Numbers number = Numbers{} - 1;  ///< of the surface; −1: none

  /// Where links with directions e cross the surface, at r + q e, in cells from the body's centre.
  template <class E>
  [[gnu::always_inline]] Film(const FilmsBeside& films, const V (&r)[3], const V& q, const E& e) {
    V point_m[3];
    for (std::size_t a = 0; a < 3; ++a) point_m[a] = films.cell_m * (r[a] + q * e[a]);
    for (std::size_t i = 0; i < films.surfaces.size(); ++i) {
      const FilmBeside& film = films.surfaces[i];
      if (by_lanes && !film.is_near) continue;
      if (all(film.distance_of_centre_m + dot(film.normal, point_m) >= film.far_m)) continue;
      V share = (thickness_m(film, point_m) - films.low_m) / (films.high_m - films.low_m);
      share = share < 0.0 ? V{} : (share > 1.0 ? V{} + 1.0 : share);
      const auto thinner = !(share >= resolved);
      resolved = thinner ? share : resolved;
      number = thinner ? Numbers{} + static_cast<std::int64_t>(i) : number;
    }
  }
};

}  // namespace copepod::fluid
