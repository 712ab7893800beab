#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "geometry/near_surfaces.hpp"

namespace copepod::coupler {

/// What becomes of films as they get thin.
struct FilmLimits {
  double roughness_m = 0.0;     ///< they are taken to be at least as thick
  bool end_at_contact = false;  ///< surfaces that overlap are in contact, and only sliding and turning have a film
};

/// One piece of the thin film between two surfaces, and its resistances. With W and v the normal and the tangential
/// velocity at x, and Δω the angular velocity, of the first surface relative to the second, the first one feels
///   F = −Z W n − F_v v + F_ω n × Δω,   T = x × F − n × T_v v + n × T_ω (n × Δω) − T_n (n·Δω) n   [theory.md, (C20)]
/// and another body on the other side the opposite. F_v, F_ω, T_v, T_ω have a value along e and one across it.
struct FilmContact {
  Eigen::Vector3d point_m;                      ///< x, in the middle of the film
  Eigen::Vector3d normal;                       ///< n, from the second surface to the first
  double gap_m = 0.0;                           ///< between the surfaces; negative where they overlap
  double squeezing_N_s_per_m = 0.0;             ///< Z
  Eigen::Vector2d sliding_N_s_per_m{0, 0};      ///< F_v
  Eigen::Vector2d force_of_turning_N_s{0, 0};   ///< F_ω
  Eigen::Vector2d torque_of_sliding_N_s{0, 0};  ///< T_v
  Eigen::Vector2d turning_N_m_s{0, 0};          ///< T_ω
  double spinning_N_m_s = 0.0;                  ///< T_n
  Eigen::Vector3d along{0, 0, 0};               ///< e, a unit vector normal to n; zero where both values are the same

  /// W of a relative motion (V, Δω) about the origin.
  [[nodiscard]] double normal_velocity(const Eigen::Vector<double, 6>& motion) const;
  /// −∂(F, T)/∂(V, Δω): about the origin, with V the relative velocity there.
  [[nodiscard]] Eigen::Matrix<double, 6, 6> resistance() const;
};

/// Finds the films between a body and a surface near it, as far as the fluid does not resolve them. A sphere has one
/// piece, with the thickness h(ρ) = h₀ + ρ²/2R. So has an ellipsoid, with the curvatures where it is nearest. A capsule
/// has one at each end, as far as the half sphere is part of the film, and slices between them, with the thickness
/// h₀ + λx²/2 across the axis.
///
/// By Reynolds' equation the pressure is p = −(3 R W + 6/5 u·x) μ/h², of a slice −6μW/(λh²). With the share 1 − w of
/// the film that the fluid does not resolve,                                                     [theory.md, (C20)]
///   Z = 6π μ R [R I₂ + (1/5 + k₁k₂R²) I₁ + …],   F_v = 2π μ R [I₁ + 3/5 q² (L + o h₀ I₂) + …],
///   F_ω = 2π μ R² [6/5 (q L + o h₀ I₂) + …],   T_v = 2π μ R² [6/5 q L + …],   T_ω = 2π μ R³ [12/5 L + …],
///   T_n = 4π μ R² [I₀ − h₀ I₁ + …],   Iₙ = ∫ (1 − w) dh/hⁿ,   L = I₁ − h₀ I₂,   q = (k₁ − k₂)/(k₁ + k₂)
/// and R the radius of their mean curvature; o = 0 between bodies, 1 at walls and mirrors. Sharply cut off, I₂ is the
/// usual 1/h₀ − 1/h_c. I₁ beside it is the next term of the exact series [Brenner, Chem. Eng. Sci. 16, 1961; Jeffrey &
/// Onishi, J. Fluid Mech. 139, 1984]. The terms left out here are what the fluid around the film lacks, since no cells
/// take up what flows out of it, fitted to the exact loads of spheres [docs/decisions/lubrication.md].
/// @param first     of the body, in the frame of `second`: relative to the body's centre
/// @param contacts  overwritten
void find_film(const NearSurface& first, const NearSurface& second, const FilmRange& range, double viscosity_Pa_s,
               const FilmLimits& limits, std::vector<FilmContact>& contacts);

/// What thin films exert on bodies, by lubrication theory (find_film): the part that the fluid leaves out of its loads
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

  [[nodiscard]] Matrix6 inverse_inertia(Eigen::Index body, const Kinematics& kinematics) const;
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
