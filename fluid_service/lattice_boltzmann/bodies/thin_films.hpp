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

  /// Part of what acts on a point of the body's surface that belongs to its loads.
  /// @param r  from the body's centre, in cells; of a body that has films beside it
  [[nodiscard]] double resolved_share(std::size_t body, const Eigen::Vector3d& r) const {
    double share = 1.0;
    for (const NearSurface& surface : surfaces_->of_body(body))
      share = std::min(share, range_.resolved_share(surface.distance_m(cell_m_ * r)));
    return share;
  }

 private:
  double cell_m_;
  FilmRange range_;
  std::optional<NearSurfaces> surfaces_;
};

}  // namespace copepod::fluid
