#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "contract/errors.hpp"
#include "contract/exchange.hpp"
#include "contract/solver_context.hpp"

// What every body solver of ours requires of its setup and of the loads of a step, and how it reports progress.

namespace copepod::body {

/// Called after every piece of a state that is written or read; empty without a context.
inline std::function<void()> progress_reporter(SolverContext* context) {
  if (context == nullptr) return {};
  return [context] { context->report_progress(); };
}

inline void require_positive_step(double step_s) {
  if (step_s > 0.0 && std::isfinite(step_s)) return;
  throw CaseError("step_s " + std::to_string(step_s) + " (must be positive). Use a positive step.");
}

/// @param nodes  number of instants of the step at which the drive is sampled
/// @throws SolverError if the loads are of another step or have the wrong shape
inline void require_matching_loads(const AppliedLoads& applied, std::int64_t step, Eigen::Index bodies,
                                   Eigen::Index actuators, Eigen::Index nodes) {
  if (applied.hydrodynamic.step != step)
    throw SolverError("loads of step " + std::to_string(applied.hydrodynamic.step) + " arrived in step " +
                          std::to_string(step) + " (steps must follow each other). Send them in order.",
                      0, step);
  if (applied.hydrodynamic.force_N.cols() == bodies && applied.hydrodynamic.torque_N_m.cols() == bodies &&
      applied.actuation.rows() == actuators && applied.actuation.cols() == nodes)
    return;
  throw SolverError("loads have the wrong shape (expected forces and torques of " + std::to_string(bodies) +
                        " bodies and values of " + std::to_string(actuators) + " actuators at " +
                        std::to_string(nodes) + " nodes). Send one column per body, and one per node.",
                    0, step);
}

}  // namespace copepod::body
