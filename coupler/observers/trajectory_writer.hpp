#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "observers/observer.hpp"
#include "storage/csv_file.hpp"

namespace copepod::coupler {

/// Writes trajectory.csv: one row per body and sample, doubles as the shortest text that reads back to the
/// same bits.
///
/// Columns: step, time_s, body, position, orientation (w, x, y, z), velocity, angular velocity, then the
/// hydrodynamic force and torque that were applied (after averaging), then the driving force at the start of
/// the step. Rows are written for every `every_steps`-th step, for the first and for the last; the row of the
/// last step holds the state at the end of the run and the loads of the step that led there. Positions are
/// not folded back into a periodic domain.
class TrajectoryWriter final : public Observer {
 public:
  /// @param every_steps  0: first and last step only
  /// @param sample_from  no samples before this step, except that of the first step
  /// @param end          where to continue the file of a run that was interrupted; absent: starts a new one
  /// @throws StorageError if the file cannot be written
  TrajectoryWriter(const std::string& path, std::vector<std::string> body_names, double step_s,
                   std::int64_t every_steps, std::int64_t sample_from = 0, const std::optional<TableEnd>& end = {});

  void observe(const StepRecord& record) override;
  void finish(const StepRecord& last) override;

  /// Hands every row so far to the operating system and the disk.
  /// @return where the table ends now
  TableEnd sync() { return file_.sync(); }

 private:
  void add_rows(const StepRecord& record);

  std::vector<std::string> body_names_;
  double step_s_;
  std::int64_t every_steps_;
  std::int64_t sample_from_;
  std::int64_t last_written_;  ///< −1: no row yet
  std::string row_;
  CsvFile file_;
};

}  // namespace copepod::coupler
