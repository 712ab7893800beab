#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "contract/exchange.hpp"

namespace copepod {

/// Results of a solver at the end of a run.
struct SolverSummary {
  std::uint64_t digest = 0;        ///< of the solver's complete state; equal digests mean equal bits
  std::uint64_t cell_updates = 0;  ///< fluid: cells of the computed domain × steps
  int ranks = 1;
  std::map<std::string, double> seconds;      ///< time per phase, named as in the trace: "map", "bulk", …
  std::set<std::string> body_phases = {};     ///< those of `seconds` that a fluid without bodies would not need
  std::set<std::string> waiting_phases = {};  ///< those of `seconds` in which the solver only waited
};

/// A fluid with moving bodies in it, advanced step by step.
///
/// Legal call order:
///   construct(FluidSetup)  ->  [restore]  ->  { exchange -> advance -> [save] }*  ->  summarise
///
/// `exchange(n)` fixes the bodies of step n and returns the loads on them; `advance()` then does the bulk
/// update of the step. A service replies to the coupler between the two, so the others
/// work while it advances. An exception from any call means that the solver is unusable from then on; it must
/// be destroyed. Only after a StorageError of `save` it remains usable and unchanged.
class FluidSolver {
 public:
  FluidSolver() = default;
  FluidSolver(const FluidSolver&) = delete;
  FluidSolver& operator=(const FluidSolver&) = delete;
  virtual ~FluidSolver() = default;

  /// Loads during step `kinematics.step` on bodies that move as given.
  /// @param loads  resized and overwritten; on return loads.step = kinematics.step
  /// @throws SolverError if the solver diverged, or a body left the domain
  virtual void exchange(const Kinematics& kinematics, Loads& loads) = 0;

  /// Bulk update of the step that `exchange` began.
  /// @throws SolverError naming rank and step if the flow diverged
  virtual void advance() = 0;

  /// Writes the state to a new file or folder `path`, complete and synced to disk on return.
  /// @throws StorageError, on all ranks alike, if the disk does not take it
  virtual void save(const std::string& path) = 0;

  /// Reads a state that `save` wrote, on any number of ranks; legal once, before the first exchange.
  /// @throws StorageError if the file is missing, damaged, or of another case
  virtual void restore(const std::string& path) = 0;

  virtual SolverSummary summarise() = 0;
};

}  // namespace copepod
