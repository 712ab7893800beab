#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"
#include "lattice_boltzmann/kernel/exchange_group.hpp"

namespace copepod::fluid {

/// Films between surfaces that are too thin for the cells: what the fluid exerts on a surface there depends on where
/// the cell centres happen to lie, so loads leave it out, and the coupler adds what lubrication theory gives.
class ThinFilms {
 public:
  explicit ThinFilms(const FluidSetup& setup) : setup_(setup), range_(setup), far_m_((1.0 + 1e-6) * range_.high_m) {}

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

  using Surfaces = std::span<const NearSurface>;

  /// What has films with a body.
  [[nodiscard]] Surfaces beside(std::size_t body) const {
    if (!surfaces_) return {};
    return surfaces_->of_body(static_cast<std::size_t>(*place_of(static_cast<int>(body))));
  }

  /// The same for exchange_groups.
  /// @param films  of the body, which refers to them
  void put(Surfaces surfaces, BodyInBlock& body, std::vector<FilmBeside>& films) const {
    for (const NearSurface& surface : surfaces)
      films.push_back({.other = surface.is_mirrored() ? -1 : surface.other,
                       .centre_m = surface.is_body() ? surface.core.centre_W_m.data() : nullptr,
                       .half_m = surface.core.half_W_m.data(),
                       .inverse_per_m2 = surface.is_ellipsoid() ? surface.inverse_per_m2.data() : nullptr,
                       .radius_m = surface.radius_m,
                       .normal = surface.normal.data(),
                       .distance_of_centre_m = surface.distance_of_centre_m,
                       .far_m = surface.stretch * far_m_});
    body.films = films.data();
    body.film_count = films.size();
    body.cell_m = setup_.cell_size_m;
    body.film_low_m = range_.low_m;
    body.film_high_m = range_.high_m;
  }

  /// The film at a point of a body's surface.
  struct Film {
    double resolved = 1.0;  ///< part of what acts there that belongs to the body's loads
    int other = -1;         ///< on the other side, among the bodies found; −1: a wall or a mirror image
    Eigen::Vector3d other_centre{0, 0, 0};  ///< of that body or its image, from the body's centre, in cells
  };

  /// The thinnest one.
  /// @param r  from the body's centre, in cells
  [[nodiscard]] Film film(Surfaces surfaces, const Eigen::Vector3d& r) const {
    Film film;
    const Eigen::Vector3d point_m = setup_.cell_size_m * r;
    for (const NearSurface& surface : surfaces) {
      if (surface.beyond_plane_m(point_m) >= surface.stretch * far_m_) continue;
      const double resolved = range_.resolved_share(surface.from(point_m).m);
      if (resolved >= film.resolved) continue;
      film = {resolved, surface.is_mirrored() ? -1 : surface.other, surface.core.centre_W_m / setup_.cell_size_m};
    }
    return film;
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
  double far_m_;  ///< where films are resolved, and more than what is rounded
  std::vector<std::int32_t> bodies_;
  std::optional<NearSurfaces> surfaces_;  ///< of these bodies, by place
};

}  // namespace copepod::fluid
