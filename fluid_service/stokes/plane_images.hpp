#pragma once

#include <Eigen/Core>

#include "contract/fluid_setup.hpp"

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

}  // namespace copepod::fluid
