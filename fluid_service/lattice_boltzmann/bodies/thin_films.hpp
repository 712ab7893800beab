#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"
#include "lattice_boltzmann/lattice/d3q19.hpp"

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
      for (const std::int32_t body : bodies) part.bodies.push_back(setup_.bodies[static_cast<std::size_t>(body)]);
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

  /// The n·r from which on no link of a cell ends in a film beside a surface, n its NearSurface::normal.
  [[nodiscard]] double reach(const NearSurface& surface) const {
    constexpr double longer_than_links = 1.5;
    return (surface.stretch * far_m_ - surface.distance_of_centre_m) / setup_.cell_size_m + longer_than_links;
  }

  /// Whether a film can be where links from a cell end: n·e nearer to a surface than the cell at least, n its normal.
  /// @param r  from the body's centre to the cell, in cells
  [[nodiscard]] bool may_meet(const NearSurface& surface, const Eigen::Vector3d& r, std::uint32_t directions) const {
    const auto [distance_m, normal] = surface.from(setup_.cell_size_m * r);
    const double beyond = (distance_m - surface.stretch * far_m_) / setup_.cell_size_m;
    double nearer = 0.0;
    for (std::uint32_t bits = directions; bits != 0; bits &= bits - 1) {
      const auto& e = d3q19::velocity[static_cast<std::size_t>(std::countr_zero(bits))];
      nearer = std::max(nearer, -normal.dot(Eigen::Vector3d(e[0], e[1], e[2])));
    }
    return beyond < nearer;
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
