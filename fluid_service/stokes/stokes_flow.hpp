#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"
#include "files/stateless_fluid.hpp"

namespace copepod::fluid {

/// What a no-slip plane at z = 0 adds to the motion of sphere i when sphere j is loaded; each (3, 3):
///   U_i += tt F_j,   Ω_i += rt F_j,   Ω_i += rr T_j
struct ImageMobility {
  Eigen::Matrix3d tt;
  Eigen::Matrix3d rt;
  Eigen::Matrix3d rr;
};

/// Mobility of the images of a sphere below a no-slip plane, in the Rotne-Prager approximation.
///
/// With y* the mirror image of the source y at height h, R = x − y*, Δ = diag(1, 1, −1), the image system of
/// a Stokeslet [Blake 1971] is, times 1/(8πη),
///   G = −S + (2h² P − 2h Q) Δ,   S = 1/R + RR/R³,   P_ij = ∂_j (R_i/R³),   Q_ij = ∂_j S_i3
/// Averages over the surfaces of spheres of radii a at x and b at y are exact with Faxén's operators, since G
/// is biharmonic inside them [Swan & Brady 2007]:
///   tt = (1 + a²/6 ∇x²)(1 + b²/6 ∇y²) G,   rt = 1/2 ∇x × (1 + b²/6 ∇y²) G,   rr = 1/4 ∇x × G × ∇y
/// For x = y these are Faxén's far-field corrections of one sphere, s = a/h:
///   parallel 1 − 9/16 s + 1/8 s³ − 1/16 s⁵,   perpendicular 1 − 9/8 s + 1/2 s³ − 1/8 s⁵
/// Being averages of the Green's function of the half space, they keep the grand mobility positive definite
/// for all spheres that do not reach the plane. No lubrication: the perpendicular mobility is 0.3 % above the
/// exact one [Brenner 1961] at h = 4 a, 6 % at 2 a, 22 % at 1.5 a.
/// @param x_m, a_m  centre and radius of sphere i; the fluid is at z > 0 [m]
/// @param y_m, b_m  the same of sphere j
ImageMobility image_mobility(const Eigen::Vector3d& x_m, double a_m, const Eigen::Vector3d& y_m, double b_m,
                             double viscosity_Pa_s);

/// The plane of a case: transforms to a frame whose third axis points from the plane into the fluid.
struct NoSlipPlane {
  Eigen::Matrix3d rotation;  ///< from the world to the plane's frame, proper
  Eigen::Vector3d origin_m;  ///< a point of the plane, in the world
};

/// @param setup  with no_slip_plane ≥ 0
NoSlipPlane no_slip_plane_of(const FluidSetup& setup);

/// Grand mobility of spheres in unbounded Stokes flow after Rotne, Prager and Yamakawa, translation and
/// rotation, unequal radii [Wajnryb, Mizerski, Zuk, Szymczak 2013; Zuk et al. 2014]:
///   (U, Ω) = M (F, T)
/// with, for spheres i ≠ j at distance r = |r_i − r_j|, direction r̂ = (r_i − r_j)/r:
///   M_tt = 1/(8πηr) [(1 + (a_i² + a_j²)/(3r²)) 1 + (1 − (a_i² + a_j²)/r²) r̂r̂],   M_tt(ii) = 1/(6πηa_i)
///   M_rr = 1/(16πηr³) [3 r̂r̂ − 1],                                              M_rr(ii) = 1/(8πηa_i³)
///   M_tr, M_rt:  U_i = T_j × r / (8πηr³),  Ω_i = F_j × r / (8πηr³)
/// Far-field: no lubrication; symmetric and positive definite while spheres do not overlap.
/// @param position_m        centres, shape (3, n) [m]
/// @param radius_m          radii, n values [m]
/// @param viscosity_Pa_s    dynamic viscosity η [Pa s]
/// @return shape (6n, 6n), rows and columns: x, y, z of all translations, then of all rotations [SI]
/// @throws SolverError if two spheres overlap
Eigen::MatrixXd grand_mobility(const Eigen::Matrix3Xd& position_m, std::span<const double> radius_m,
                               double viscosity_Pa_s);

/// Adds what a no-slip plane does to the mobility of the same spheres, in the same order; see image_mobility.
/// @throws SolverError if a sphere reaches the plane
void add_plane_images(Eigen::MatrixXd& mobility, const NoSlipPlane& plane, const Eigen::Matrix3Xd& position_m,
                      std::span<const double> radius_m, double viscosity_Pa_s);

/// Quasi-steady Stokes flow around spheres, in unbounded fluid or beside one no-slip plane: the loads are
/// those that make the spheres move as given,
///   M (F, T) = −(U, Ω)                                     M: grand_mobility above
/// Neglected: inertia of the fluid, lubrication, other walls.
class StokesFlow final : public StatelessFluid {
 public:
  /// @throws CaseError for bodies that are not spheres
  StokesFlow(const FluidSetup& setup, const Communicator& communicator);

  SolverSummary summarise() override;

 private:
  void add_loads(const Kinematics& kinematics, Loads& loads) override;

  double viscosity_Pa_s_;
  std::vector<double> radius_m_;
  std::optional<NoSlipPlane> plane_;
  double exchange_s_ = 0.0;
};

}  // namespace copepod::fluid
