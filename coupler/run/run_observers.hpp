#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "analysis/balance.hpp"
#include "analysis/cycle_observer.hpp"
#include "checkpoint/coupler_state.hpp"
#include "config/load_case.hpp"
#include "observers/bodies_writer.hpp"
#include "observers/events.hpp"
#include "observers/observer.hpp"
#include "observers/trajectory_writer.hpp"
#include "storage/run_directory.hpp"

namespace copepod::coupler {

/// The observers of a run: trajectory, surfaces of the bodies, analysis, progress.
class RunObservers final : public Observer {
 public:
  /// References must outlive this object.
  /// @param resumed  the checkpoint that the run continues from; null: it starts
  /// @param step     receives the step that is being computed
  /// @throws StorageError if files cannot be written, or are not what the checkpoint needs
  RunObservers(const LoadedCase& loaded, const RunDirectory& directory, Events& events, const CouplerState* resumed,
               std::int64_t& step);

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  [[nodiscard]] CycleObserver& cycles() { return cycles_; }
  [[nodiscard]] Balance& balance() { return balance_; }

  /// Brings all rows so far to the disk.
  /// @return where the tables end now
  TableEnds sync_files();

 private:
  const RunDirectory& directory_;
  std::int64_t& step_;
  std::filesystem::path trajectory_path_;
  std::unique_ptr<TrajectoryWriter> trajectory_;
  std::filesystem::path obstacles_path_;
  std::optional<ObstacleWriter> obstacles_;                ///< where there are any with loads
  std::optional<BodiesWriter> bodies_;                     ///< if asked for
  std::map<std::filesystem::path, SampleWriter> samples_;  ///< flow.csv, coefficients.csv; likewise
  Progress progress_;
  std::optional<CycleTable> cycle_table_;  ///< where there are cycles to measure
  CycleObserver cycles_;
  Balance balance_;
  std::vector<Observer*> all_;  ///< in the order of their calls
};

}  // namespace copepod::coupler
