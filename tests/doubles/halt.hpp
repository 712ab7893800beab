#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "contract/solver.hpp"
#include "contract/solver_context.hpp"

namespace copepod::doubles {

/// A place in a solver where it stops moving, so that a test can hurt a run in a known phase.
struct Halt {
  std::string in;            ///< start, construct, exchange, advance, save or summarise; empty: nowhere
  std::int64_t at_step = 0;  ///< exchange, advance and save: at the first one of this step or a later one
  int rank = 0;              ///< on which rank
  std::string file;          ///< made when the place is reached; the solver continues when it is removed
  bool hangs = false;        ///< never continues and shows no progress; otherwise it is slow but moving
};

/// Halts if this is the place.
/// @param context  to show progress to meanwhile; null before there is a solver
void halt_here(const Halt& halt, const std::string& place, std::int64_t step = 0, SolverContext* context = nullptr);

/// Solvers that halt; `rank` is that of the solver.
std::unique_ptr<FluidSolver> halting(std::unique_ptr<FluidSolver> solver, const Halt& halt, int rank,
                                     SolverContext& context);
std::unique_ptr<BodySolver> halting(std::unique_ptr<BodySolver> solver, const Halt& halt, SolverContext& context);

}  // namespace copepod::doubles
