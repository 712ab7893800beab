#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"
#include "scheme/film.hpp"

namespace copepod::coupler {

/// What thin films exert on bodies, by lubrication theory (film.hpp): the part that the fluid leaves out of its loads
/// (FluidSetup::film_thickness_m). It is part of the coupling, which has the positions, velocities and masses of all
/// bodies, so that neither fluids nor body components need to.
///
/// The drag of a film grows without bound as the film gets thinner, and explicit films would be unstable. They act on
/// the velocities at the end of the step, as far as the loads that the coupler has determine them:
///   L = −K w(V'),   V' = V + Δt M⁻¹ (L_others + Σ L)                                                    (C21)
/// with w the relative motion of the two surfaces. The films are solved one after the other until nothing changes,
/// which is at once where no body has several. So films of any thickness are stable, and a body under a constant load
/// approaches a surface at the right velocity whatever the step. Where a film gets thinner or thicker by more than a
/// tenth within a step, the step is divided, and the loads are the mean of its parts: a body that hits a surface loses
/// what theory demands, whatever the step (C22). Averaging does not apply to films. Bodies that overlap at a joint have
/// no film between them; to its films a jointed body has its own mass alone. Where contacts are resolved, films resist
/// the approach of surfaces until they touch, and their separation from then on.
class Lubrication {
 public:
  /// No films.
  Lubrication() = default;

  /// @param fluid        a film thickness of 0: no films
  /// @param bodies       in the order of the fluid's, with the masses that the body component has
  /// @param roughness_m  films do not get thinner
  Lubrication(const FluidSetup& fluid, const BodySetup& bodies, double roughness_m);

  /// Loads of all films on the bodies; nullptr where there are none.
  /// @param applied, drive  all other loads but weight and those that act between bodies
  const Loads* loads(const Kinematics& kinematics, const Loads& applied, const Loads& drive);

 private:
  using Vector6 = Eigen::Vector<double, 6>;  ///< velocity, angular velocity; or force, torque
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// Between a body and another one, or the image of one, or a wall; all about the centre of the first body.
  struct Film {
    int body = 0;
    int other = -1;                        ///< −1: a wall
    bool image = false;                    ///< of `other`, whose own film with the image of `body` gives it its load
    Vector6 wall = Vector6::Zero();        ///< velocity of the wall
    Matrix6 to_other = Matrix6::Zero();    ///< motion of the surface by that of the other body
    Matrix6 resistance = Matrix6::Zero();  ///< K
    Matrix6 response = Matrix6::Zero();    ///< change of the relative motion by a load, Δt M⁻¹ of both bodies
    Matrix6 answer = Matrix6::Zero();      ///< (1 + K Δt M⁻¹)⁻¹ K
    Vector6 load = Vector6::Zero();

    [[nodiscard]] Vector6 relative(const std::vector<Vector6>& motion) const;
  };

  [[nodiscard]] Matrix6 inverse_inertia(std::size_t body, const Kinematics& kinematics) const;
  void find_films();
  void add_film(int body, const NearSurface& surface);
  [[nodiscard]] double duration_s(double left_s) const;
  void predict(double duration_s, const Loads& applied, const Loads& drive);
  void solve();
  void add_up(double share);
  void move(double duration_s);

  FluidSetup fluid_;
  BodySetup bodies_;
  FilmLimits limits_;
  std::optional<NearSurfaces> surfaces_;
  std::vector<FilmContact> contacts_;
  Kinematics moved_;               ///< of all bodies, as far as the step is done
  double fastest_per_s_ = 0.0;     ///< rate at which a film changes its thickness, by its thickness
  std::vector<Matrix6> response_;  ///< Δt M⁻¹ by body
  std::vector<Vector6> motion_;    ///< V' by body
  std::vector<Film> films_;
  Loads loads_;
};

}  // namespace copepod::coupler
