#pragma once

#include <vector>

#include "contract/exchange.hpp"
#include "contract/solver.hpp"

namespace copepod {

/// Rigid bodies with springs, advanced step by step.
///
/// Legal call order:
///   construct(BodySetup)  ->  [restore]  ->  kinematics  ->  { step -> [save] }*  ->  summarise
class BodySolver : public Solver {
 public:
  /// Where inside a step the actuators' values are needed, as fractions of the step, ascending, the first 0.
  [[nodiscard]] virtual std::vector<double> driving_nodes() const = 0;

  /// State of motion at the start of the next step.
  virtual void kinematics(Kinematics& kinematics) = 0;

  /// Advances from step n = applied.hydrodynamic.step to n + 1.
  /// @param next  resized and overwritten with the state at the start of step n + 1
  /// @throws SolverError if bodies overlap (named), or a state is not finite
  virtual void step(const AppliedLoads& applied, Kinematics& next) = 0;
};

}  // namespace copepod
