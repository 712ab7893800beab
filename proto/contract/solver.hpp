#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>

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

}  // namespace copepod
