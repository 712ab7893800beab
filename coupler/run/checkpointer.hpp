#pragma once

#include <cstdint>

#include "checkpoint/checkpoint_schedule.hpp"
#include "checkpoint/checkpoint_store.hpp"
#include "config/sections/case.hpp"
#include "observers/events.hpp"
#include "run/components.hpp"
#include "run/run_observers.hpp"
#include "run/signals.hpp"
#include "scheme/serial_explicit.hpp"

namespace copepod::coupler {

/// Which steps enter the mean field that a case asks for.
MeanSampling mean_sampling(const OutputCase& output);

/// Interrupts a run where a checkpoint is due or a signal came, and writes checkpoints.
class Checkpointer {
 public:
  /// References must outlive this object.
  /// @param able  whether both components can save; if not, signals only stop
  enum class Ability { none, saves };
  Checkpointer(const CheckpointStore& store, Components& components, Ability able, const Case& the_case,
               std::int64_t first_step, RunSignals& signals, Events& events);
  Checkpointer(const Checkpointer&) = delete;
  Checkpointer& operator=(const Checkpointer&) = delete;
  ~Checkpointer();

  /// Whether the run should pause before `step`; never before the first one, where there is nothing to save.
  /// @throws Interrupted if a signal asked the run to end now
  bool wants_pause(std::int64_t step);

  /// Writes a checkpoint of the pausing run. A disk that does not take it is reported, and the run continues.
  /// @throws Interrupted after it, if SIGTERM asked for it; what the solvers throw
  void write(FluidSolver& fluid, BodySolver& body, const SerialExplicit& scheme, RunObservers& observers);

 private:
  void commit(FluidSolver& fluid, BodySolver& body, const SerialExplicit& scheme, RunObservers& observers);

  CheckpointStore store_;
  Components& components_;
  Ability able_;
  std::int64_t first_step_;
  CheckpointSchedule schedule_;
  MeanSampling mean_;
  std::uintmax_t expected_bytes_;  ///< of the first checkpoint
  RunSignals& signals_;
  Events& events_;
};

}  // namespace copepod::coupler
