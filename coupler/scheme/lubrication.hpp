#pragma once

#include <optional>
#include <vector>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"
#include "scheme/film.hpp"

namespace copepod::coupler {

/// What thin films exert on bodies, by lubrication theory (film.hpp): the part that the fluid leaves out of its loads
/// (FluidSetup::film_thickness_m). It is part of the coupling, which knows positions, velocities and masses of all
/// bodies, so that neither fluids nor body components have to.
///
/// The resistance of a film is limited to what takes half of the relative motion in one step, so that the coupling,
/// which is explicit, is stable for films of any thickness. Averaging does not apply: it would halve this limit, and
/// there is no noise to remove.
class Lubrication {
 public:
  /// No films.
  Lubrication() = default;

  /// @param fluid        a film thickness of 0: no films
  /// @param bodies       with the masses that the body component has, in the order of the fluid's
  /// @param roughness_m  films do not get thinner
  Lubrication(const FluidSetup& fluid, const std::vector<BodySpecification>& bodies, double roughness_m);

  /// Adds the loads of all films to those of the fluid, raw and averaged.
  void add_to(Loads& raw, Loads& averaged, const Kinematics& kinematics);

 private:
  /// What an impulse changes: 1/M and, about the axis of the smallest moment, 1/I; 0 for what no load moves.
  struct Mobility {
    double per_mass_per_kg = 0.0;
    double per_inertia_per_kg_m2 = 0.0;
  };
  /// Of a body or of a wall.
  struct Motion {
    Eigen::Vector3d centre_m{0, 0, 0};  ///< relative to the body that is looked at
    Eigen::Vector3d velocity_m_per_s{0, 0, 0};
    Eigen::Vector3d angular_velocity_rad_per_s{0, 0, 0};
    Mobility mobility;

    [[nodiscard]] Eigen::Vector3d velocity_at_m_per_s(const Eigen::Vector3d& point_m) const {
      return velocity_m_per_s + angular_velocity_rad_per_s.cross(point_m - centre_m);
    }
    /// By which a contact's resistances slow the motion down [1/s].
    [[nodiscard]] double damping_per_s(const FilmContact& contact) const;
  };

  [[nodiscard]] Motion motion_of(std::size_t body, const Kinematics& kinematics) const;
  [[nodiscard]] Motion motion_of(const NearSurface& surface, const Kinematics& kinematics) const;
  void find_contacts(std::size_t body, const NearSurface& surface, const Kinematics& kinematics);
  void add_film(std::size_t body, const NearSurface& surface, const Kinematics& kinematics);

  FluidSetup fluid_;
  std::vector<Mobility> mobilities_;  ///< by body
  double roughness_m_ = 0.0;
  std::optional<NearSurfaces> surfaces_;
  std::vector<FilmContact> contacts_;
  Loads films_;
};

}  // namespace copepod::coupler
