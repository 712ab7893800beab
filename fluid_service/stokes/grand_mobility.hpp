#pragma once

#include <span>

#include <Eigen/Core>

#include "stokes/plane_images.hpp"

namespace copepod::fluid {

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

}  // namespace copepod::fluid
