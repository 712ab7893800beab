#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contract/fluid_setup.hpp"
#include "observers/observer.hpp"
#include "storage/table_file.hpp"

namespace copepod::coupler {

/// Where the samples of a trajectory go.
struct TrajectoryFile {
  std::unique_ptr<TableFile> table;
  std::function<void(const StepRecord& record, double time_s)> add;
};

/// Writes trajectory.csv or trajectory.npy: position, orientation (w, x, y, z), velocity and angular velocity of every
/// body, the hydrodynamic force and torque that were applied (after averaging), and the driving force at the start of
/// the step, with the same numbers in either form.
///
/// trajectory.csv has one row per body and sample, doubles as the shortest text that reads back to the same bits;
/// trajectory.npy is an array of samples, each with `step`, `time_s` and an array (bodies, components) for each
/// quantity; trajectory_names.txt has the names of the bodies. There is a sample for every `every_steps`-th step, for
/// the first and for the last; that of the last step holds the state at the end of the run and the loads of the step
/// that led there. Positions are not folded back into the periodic domain.
class TrajectoryWriter final : public Observer {
 public:
  /// @param path         its suffix decides the form
  /// @param every_steps  0: first and last step only
  /// @param sample_from  no samples before this step, except that of the first step
  /// @param end          where to continue the file of a run that was interrupted; absent: starts a new one
  /// @throws StorageError if the file cannot be written
  TrajectoryWriter(const std::string& path, const std::vector<std::string>& body_names, double step_s,
                   std::int64_t every_steps, std::int64_t sample_from = 0, const std::optional<TableEnd>& end = {});

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  /// Hands every sample so far to the operating system and the disk.
  /// @return where the table ends now
  TableEnd sync() { return file_.table->sync(); }

 private:
  void add(const StepRecord& record);

  double step_s_;
  std::int64_t every_steps_;
  std::int64_t sample_from_;
  std::int64_t last_written_;  ///< −1: no sample yet
  TrajectoryFile file_;
};

/// Writes a table such as flow.csv: step, time and values of its start, a row for each step that has any.
class SampleWriter final : public Observer {
 public:
  using Values = std::function<Eigen::VectorXd(const StepRecord&)>;
  /// @param names  of the values
  /// @throws StorageError as TrajectoryWriter
  SampleWriter(const std::string& path, const std::vector<std::string>& names, double step_s, Values values,
               const std::optional<TableEnd>& end);

  void observe(const StepRecord& record) override;
  void finish(const StepRecord&) override { file_.flush(); }
  TableEnd sync() { return file_.sync(); }

 private:
  double step_s_;
  Values values_;
  CsvFile file_;
};

/// Writes obstacles.csv or obstacles.npy: the loads on obstacles that ask for them, as a trajectory of bodies at rest.
class ObstacleWriter final : public Observer {
 public:
  /// @param obstacles  those with loads
  /// @param writer     with their names
  ObstacleWriter(const std::vector<ObstacleSpecification>& obstacles, std::unique_ptr<TrajectoryWriter> writer);

  void observe(const StepRecord& record) override { writer_->observe(of_obstacles(record)); }
  void finish(const StepRecord& last) override { writer_->finish(of_obstacles(last)); }
  TableEnd sync() { return writer_->sync(); }

 private:
  [[nodiscard]] StepRecord of_obstacles(const StepRecord& record) const {
    const Loads& loads = record.obstacles.bodies() > 0 ? record.obstacles : no_loads_;
    return {record.step, places_, loads, loads, no_loads_, loads};
  }

  Kinematics places_;
  Loads no_loads_;  ///< before the first step, and of the drive
  std::unique_ptr<TrajectoryWriter> writer_;
};

}  // namespace copepod::coupler
