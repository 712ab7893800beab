#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"
#include "lattice_boltzmann/kernel/film.hpp"

namespace copepod::fluid {

/// Films between surfaces that are too thin for the cells: what the fluid exerts on a surface there depends on where
/// the cell centres happen to lie, so loads leave it out, and the coupler adds what lubrication theory gives.
class ThinFilms {
 public:
  explicit ThinFilms(const FluidSetup& setup) : setup_(setup), range_(setup) {}

  /// Looks at some bodies of the setup only.
  /// @param bodies      ascending
  /// @param kinematics  of these, in this order
  void find(const std::vector<std::int32_t>& bodies, const Kinematics& kinematics) {
    if (setup_.film_thickness_m <= 0.0) return;
    if (!surfaces_ || bodies != bodies_) {
      bodies_ = bodies;
      FluidSetup part = setup_;
      part.bodies.clear();
      for (const std::int32_t body : bodies) part.bodies.push_back(setup_.bodies[body]);
      part.jointed.clear();
      for (const auto& [A, B] : setup_.jointed)
        if (const auto a = place_of(A), b = place_of(B); a && b) part.jointed.emplace_back(*a, *b);
      surfaces_.emplace(part, range_.high_m);
    }
    surfaces_->find(kinematics);
  }

  /// What has films with a body; refers to what find() has found.
  [[nodiscard]] FilmsBeside beside(std::size_t body) const {
    FilmsBeside films{.cell_m = setup_.cell_size_m, .low_m = range_.low_m, .high_m = range_.high_m};
    if (!surfaces_) return films;
    const double far_m = (1.0 + 1e-6) * range_.high_m;  // where they are resolved, and more than what is rounded
    for (const NearSurface& surface : surfaces_->of_body(*place_of(static_cast<int>(body))))
      films.surfaces.push_back({.other = surface.is_mirrored() ? -1 : surface.other,
                                .centre_m = surface.is_body() ? surface.core.centre_W_m.data() : nullptr,
                                .half_m = surface.core.half_W_m.data(),
                                .inverse_per_m2 = surface.is_ellipsoid() ? surface.inverse_per_m2.data() : nullptr,
                                .radius_m = surface.radius_m,
                                .normal = surface.normal.data(),
                                .distance_of_centre_m = surface.distance_of_centre_m,
                                .far_m = surface.stretch * far_m});
    return films;
  }

 private:
  /// Of a body among those that are looked at.
  [[nodiscard]] std::optional<int> place_of(int body) const {
    const auto found = std::ranges::lower_bound(bodies_, body);
    if (found == bodies_.end() || *found != body) return std::nullopt;
    return static_cast<int>(found - bodies_.begin());
  }

  FluidSetup setup_;
  FilmRange range_;
  std::vector<std::int32_t> bodies_;
  std::optional<NearSurfaces> surfaces_;  ///< of these bodies, by place
};

}  // namespace copepod::fluid
