#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "contract/exchange.hpp"

namespace copepod {

/// Results of a solver at the end of a run.
struct SolverSummary {
  std::uint64_t digest = 0;                   ///< of the solver's complete state; equal digests mean equal bits
  std::uint64_t cell_updates = 0;             ///< fluid: cells of the computed domain × steps
  int ranks = 1;                              ///< processes of the solver
  std::map<std::string, double> seconds;      ///< time per phase, named as in the trace: "map", "bulk", …
  std::set<std::string> body_phases = {};     ///< those of `seconds` that a fluid without bodies would not need
  std::set<std::string> waiting_phases = {};  ///< those of `seconds` in which the solver only waited
  std::optional<double> mass_drift = {};      ///< fluid: mass gained since it was at rest, by its mass
  /// Fluid with bodies on a grid: |momentum gained from neither a body, a wall nor a force| over the sum of the
  /// |impulses| that its bodies received, since step 0.
  std::optional<double> momentum_drift = {};
};

/// What fluids and bodies have in common. An exception from any call means that the solver is unusable from then
/// on; it must be destroyed. Only after a StorageError of `save` it remains usable and unchanged.
class Solver {
 public:
  Solver() = default;
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;
  virtual ~Solver() = default;

  /// Writes the state to a new file or folder `path`, complete and synced to disk on return.
  /// @throws StorageError if the disk does not take it, on all ranks alike
  virtual void save(const std::string& path) = 0;

  /// Reads a state that `save` wrote, on any number of ranks; legal once, before the first exchange. The solver that
  /// wrote it may have had other drives, springs, masses or numerics: a run may start from a state of another one.
  /// @throws StorageError if the file is missing, damaged, or a state of other bodies or another domain
  virtual void restore(const std::string& path) = 0;

  virtual SolverSummary summarise() = 0;  ///< digest and figures of the run so far; legal between two steps
};

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
