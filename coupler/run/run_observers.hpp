#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "analysis/swimmer_observer.hpp"
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

  /// One report per swimmer, for the summary.
  [[nodiscard]] nlohmann::ordered_json swimmer_reports() const;

  /// State of the analysis, one entry per swimmer.
  [[nodiscard]] std::vector<PeriodSums> sums() const;
  /// @throws StorageError if the number of swimmers differs
  void restore(const std::vector<PeriodSums>& sums);

  void sync_files() { trajectory_.sync(); }

 private:
  const Case& case_;
  StepKeeper keeper_;
  TrajectoryWriter trajectory_;
  Progress progress_;
  std::vector<std::unique_ptr<SwimmerObserver>> swimmers_;
  Observers all_;
};

}  // namespace copepod::coupler
