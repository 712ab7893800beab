#pragma once

#include "contract/exchange.hpp"
#include "contract/solver.hpp"

namespace copepod {

/// A fluid with moving bodies in it, advanced step by step.
///
/// Legal call order:
///   construct(FluidSetup)  ->  [restore]  ->  { exchange -> advance -> [save] }*  ->  summarise
///
/// `exchange(n)` fixes the bodies of step n and returns the loads on them; `advance()` then does the bulk update of the
/// step. A service replies to the coupler between the two, so the others work while it advances.
class FluidSolver : public Solver {
 public:
  /// Loads during step `kinematics.step` on bodies that move as given.
  /// @param loads  resized and overwritten; on return loads.step = kinematics.step
  /// @throws SolverError if the solver diverged, or a body left the domain
  virtual void exchange(const Kinematics& kinematics, Loads& loads) = 0;

  /// Bulk update of the step that `exchange` began.
  /// @throws SolverError naming rank and step if the flow diverged
  virtual void advance() = 0;
};

}  // namespace copepod
