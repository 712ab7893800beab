#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "analysis/cycle_observer.hpp"
#include "config/load_case.hpp"
#include "observers/events.hpp"
#include "observers/observer.hpp"
#include "observers/progress.hpp"
#include "observers/trajectory_writer.hpp"
#include "storage/run_directory.hpp"

namespace copepod::coupler {

/// Remembers how far a run came, for the report of a failure.
class StepKeeper final : public Observer {
 public:
  /// @param step  overwritten with every step; must outlive this object
  explicit StepKeeper(std::int64_t& step) : step_(step) {}
  void observe(const StepRecord& record) override { step_ = record.step; }
  void finish(const StepRecord& last) override { step_ = last.step; }

 private:
  std::int64_t& step_;
};

/// The observers of a run: trajectory, analysis, progress.
class RunObservers {
 public:
  /// References must outlive this object.
  /// @param first_step  0, or that of the checkpoint which is resumed
  /// @param step        receives the step that is being computed
  RunObservers(const LoadedCase& loaded, const RunDirectory& directory, Events& events, std::int64_t first_step,
               std::int64_t& step);

  Observer& all() { return all_; }

  [[nodiscard]] CycleObserver& cycles() { return cycles_; }

  void sync_files();

 private:
  StepKeeper keeper_;
  TrajectoryWriter trajectory_;
  Progress progress_;
  std::optional<CycleTable> cycle_table_;  ///< where there are cycles to measure
  CycleObserver cycles_;
  Observers all_;
};

}  // namespace copepod::coupler
