#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <optional>
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
  explicit ThinFilms(const FluidSetup& setup)
      : setup_(setup), range_(setup), high_(range_.high_m / setup.cell_size_m) {}

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

  [[nodiscard]] bool beside(std::size_t body) const { return surfaces_ && !of_body(body).empty(); }

  /// Whether a film can be where links from a cell meet the surface of a body, which has films beside it.
  /// @param r  from the body's centre to the cell, in cells
  [[nodiscard]] bool may_meet(std::size_t body, const Eigen::Vector3d& r, std::uint32_t directions) const {
    return directions != 0 && std::ranges::any_of(of_body(body), [&](const NearSurface& surface) {
             const double beyond = surface.distance_m(setup_.cell_size_m * r) / setup_.cell_size_m - high_;
             if (beyond >= 1.5) return false;  // more than the longest link
             double nearer = 1e-6;             // along a link, at most; more than what is rounded
             for (std::uint32_t bits = directions; bits != 0; bits &= bits - 1) {
               const auto& e = d3q19::velocity[static_cast<std::size_t>(std::countr_zero(bits))];
               const Eigen::Vector3d link(e[0], e[1], e[2]);
               nearer = std::max(nearer, 1e-6 + (surface.is_body() ? link.norm() : -link.dot(surface.normal)));
             }
             return beyond < nearer;
           });
  }

  /// The film at a point of a body's surface.
  struct Film {
    double resolved = 1.0;  ///< part of what acts there that belongs to the body's loads
    int other = -1;         ///< on the other side, among the bodies found; −1: a wall or a mirror image
    Eigen::Vector3d other_centre{0, 0, 0};  ///< of that body or its image, from the body's centre, in cells
  };

  /// The thinnest one.
  /// @param r  from the body's centre, in cells; of a body that has films beside it
  [[nodiscard]] Film film(std::size_t body, const Eigen::Vector3d& r) const {
    Film film;
    for (const NearSurface& surface : of_body(body)) {
      const double resolved = range_.resolved_share(surface.distance_m(setup_.cell_size_m * r));
      if (resolved >= film.resolved) continue;
      film = {resolved, surface.is_mirrored() ? -1 : surface.other, surface.core.centre_W_m / setup_.cell_size_m};
    }
    return film;
  }

 private:
  [[nodiscard]] const std::vector<NearSurface>& of_body(std::size_t body) const {
    return surfaces_->of_body(static_cast<std::size_t>(*place_of(static_cast<int>(body))));
  }

  /// Of a body among those that are looked at.
  [[nodiscard]] std::optional<int> place_of(int body) const {
    const auto found = std::ranges::lower_bound(bodies_, body);
    if (found == bodies_.end() || *found != body) return std::nullopt;
    return static_cast<int>(found - bodies_.begin());
  }

  FluidSetup setup_;
  FilmRange range_;
  double high_;  ///< of the range, in cells
  std::vector<std::int32_t> bodies_;
  std::optional<NearSurfaces> surfaces_;  ///< of these bodies, by place
};

}  // namespace copepod::fluid
