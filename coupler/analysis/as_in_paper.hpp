#pragma once

#include "analysis/swimmer_figures.hpp"
#include "observers/observer.hpp"

namespace copepod::coupler {

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

/// @param power_W  mean of power_with_rounded_omega_W
FiguresAsInPaper evaluate_as_in_paper(const SwimmerFigures& figures, const SwimmerMeasurement& measured, double power_W,
                                      const Swimmer& swimmer, const Case& the_case);

}  // namespace copepod::coupler
