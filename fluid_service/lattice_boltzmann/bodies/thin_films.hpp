#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"

namespace copepod::fluid {

/// Films between surfaces that are too thin for the cells: what the fluid exerts on a surface there depends on where
/// the cell centres happen to lie, so loads leave it out, and the coupler adds what lubrication theory gives.
class ThinFilms {
 public:
  explicit ThinFilms(const FluidSetup& setup) : cell_m_(setup.cell_size_m), range_(setup) {
    if (setup.film_thickness_m > 0.0) surfaces_.emplace(setup, range_.high_m);
  }

  void find(const Kinematics& kinematics) {
    if (surfaces_) surfaces_->find(kinematics);
  }

  [[nodiscard]] bool beside(std::size_t body) const { return surfaces_ && !surfaces_->of_body(body).empty(); }

  /// The film at a point of a body's surface.
  struct Film {
    double resolved = 1.0;                  ///< part of what acts there that belongs to the body's loads
    int other = -1;                         ///< body on the other side; −1: a wall or a mirror image
    Eigen::Vector3d other_centre{0, 0, 0};  ///< of that body or its image, from the body's centre, in cells
  };

  /// The thinnest one.
  /// @param r  from the body's centre, in cells; of a body that has films beside it
  [[nodiscard]] Film film(std::size_t body, const Eigen::Vector3d& r) const {
    Film film;
    for (const NearSurface& surface : surfaces_->of_body(body)) {
      const double resolved = range_.resolved_share(surface.distance_m(cell_m_ * r));
      if (resolved >= film.resolved) continue;
      film = {resolved, surface.is_mirrored() ? -1 : surface.other, surface.core.centre_W_m / cell_m_};
    }
    return film;
  }

 private:
  double cell_m_;
  FilmRange range_;
  std::optional<NearSurfaces> surfaces_;
};

}  // namespace copepod::fluid
