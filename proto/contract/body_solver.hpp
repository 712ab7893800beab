#pragma once

#include <string>
#include <vector>

#include "contract/exchange.hpp"
#include "contract/fluid_solver.hpp"

namespace copepod {

/// Rigid bodies with springs, advanced step by step.
///
/// Legal call order:
///   construct(BodySetup)  ->  [restore]  ->  kinematics  ->  { step -> [save] }*  ->  summarise
///
/// An exception from any call means that the solver is unusable from then on; it must be destroyed.
class BodySolver {
 public:
  BodySolver() = default;
  BodySolver(const BodySolver&) = delete;
  BodySolver& operator=(const BodySolver&) = delete;
  virtual ~BodySolver() = default;

  /// Where inside a step the driving forces are needed, as fractions of the step, ascending, the first 0.
  [[nodiscard]] virtual std::vector<double> driving_nodes() const = 0;

  /// State of motion at the start of the next step.
  virtual void kinematics(Kinematics& kinematics) = 0;

  /// Advances from step n = applied.hydrodynamic.step to n + 1.
  /// @param next  resized and overwritten with the state at the start of step n + 1
  /// @throws SolverError if bodies overlap (named), or a state is not finite
  virtual void step(const AppliedLoads& applied, Kinematics& next) = 0;

  /// As FluidSolver::save and FluidSolver::restore.
  virtual void save(const std::string& path) = 0;
  virtual void restore(const std::string& path) = 0;

  virtual SolverSummary summarise() = 0;
};

}  // namespace copepod
