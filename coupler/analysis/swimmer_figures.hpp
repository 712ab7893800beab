#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "analysis/cycle_observer.hpp"
#include "config/sections/case.hpp"
#include "contract/shape.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

// Beads of a three-bead swimmer: trailing B2, middle B1, leading B3; arms B2-B1, B1-B3.

/// The figures that depend on ω.
struct OmegaFigures {
  double omega_rad_per_s = 0.0;
  double u_GA_m_per_s = 0.0;         ///< [paper, eq. (28)]
  double error_percent = 0.0;        ///< [paper, eq. (30)]
  std::optional<double> efficiency;  ///< [paper, eq. (31)]; absent in vacuum
};

/// Result row of one swimmer; SI units, Reynolds numbers and efficiency absent in vacuum.
struct SwimmerFigures {
  double u_swim_m_per_s = 0.0;
  double sin_dphi = 0.0;                           ///< sin(φ₁ − φ₂)
  double K_per_m = 0.0;                            ///< [paper, eq. (29)]
  OmegaFigures at_omega;                           ///< with ω = 2π/T
  std::optional<double> Re_swim;                   ///< [paper, eq. (25)]
  std::array<std::optional<double>, 3> Re_bodies;  ///< of B2, B1, B3 [paper, eq. (26)]
};

/// Radius that stands for a body in K and r_eff [m]: a quarter of the sum of its extents along and across the swimmer's
/// axis. A capsule along or across it counts as the sphere with the mean of both for diameter (12 cells in the paper).
inline double equivalent_radius_m(const Shape& shape) { return shape.radius_m + 0.5 * core_half_length_m(shape); }

/// Efficiency after Lighthill [paper, eq. (31)]: 6π η r u² / P; absent in vacuum and without power.
/// @param effective_radius_m  r, sum of the equivalent radii
std::optional<double> efficiency(double effective_radius_m, double speed_m_per_s, double power_W,
                                 const FluidSetup& fluid);

/// Geometrical factor [1/m] [paper, eq. (29)]:
///   K = 3 r₁r₂r₃ / (2 (r₁+r₂+r₃)²) · [1/l̄₁² + 1/l̄₂² − 1/(l̄₁+l̄₂)²]
double geometrical_factor_per_m(const std::array<double, 3>& radii_m, const std::array<double, 2>& mean_arms_m);

/// Rest length of the whole swimmer along its axis [m]: extents of the beads and both gaps.
double rest_length_m(const Swimmer& swimmer);

/// Equations (24)-(31) of the paper, of the last full driven period.
/// @param axis  own axis at its start
SwimmerFigures evaluate(const Cycle& cycle, const Eigen::Vector3d& axis, const Swimmer& swimmer, const Case& the_case);

// What repeats the paper's tables where they deviate from its equations: ω rounded as in the captions, and
// Reynolds numbers in exchanged columns. No other evaluation uses it [docs/theory.md].

/// ω = 2π/T per step, rounded to two significant digits as in the captions of the paper's tables (0.00022).
double rounded_omega_per_step(std::int64_t period_steps);

/// Power in one step of the forces that the stroke would have with the rounded ω [W] (physics of the tables,
/// not of the run): −a sin(ωt) on B2, a sin(ω(t − φ)) on B3, the negative sum on B1.
/// @param first_body  column of the trailing bead
/// @param axis        along which they act: unit vector from trailing to leading
double power_with_rounded_omega_W(const Stroke& stroke, int first_body, const Eigen::Vector3d& axis,
                                  const StepRecord& record);

struct FiguresAsInPaper {
  OmegaFigures at_rounded_omega;
  std::array<std::optional<double>, 3> Re_bodies;  ///< velocities of B2 and B1 exchanged
};

/// @param cycle  with the mean of power_with_rounded_omega_W
FiguresAsInPaper evaluate_as_in_paper(const SwimmerFigures& figures, const Cycle& cycle, const Swimmer& swimmer,
                                      const Case& the_case);

/// Distance from each of several points to the nearest other one [m], in time linear in their number where they are
/// spread evenly: balls about the points grow until they meet another.
/// @param points_m           finite, shape (3, points ≥ 2)
/// @param periodic_length_m  of the domain; 0: not periodic along this axis
Eigen::VectorXd nearest_distances_m(const Eigen::Matrix3Xd& points_m, const std::array<double, 3>& periodic_length_m);

/// The swimmers' part of summary.json: `swimmers`, an entry for each, `groups` where the case has them,
/// and for several swimmers `swarm`. Lattice figures
/// are in cells and steps (null without a cell size); what the run did not reach or the fluid has not got is null.
nlohmann::ordered_json swimmer_reports(const Case& the_case, const CycleObserver& observer);

}  // namespace copepod::coupler
