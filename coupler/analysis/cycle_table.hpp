#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/cycle.hpp"
#include "storage/csv_file.hpp"

namespace copepod::coupler {

/// Writes cycles.csv: one row per swimmer and full cycle, in the order in which cycles end.
///
/// Columns: swimmer, cycle, its first step and time; centroid and own axis at its start, angle of that axis to the one
/// in the case; mean velocity along and across that axis and in the world; rotation vector from start to end; mean
/// power of the drive and mean power given to the fluid; efficiency and Reynolds number (empty in vacuum); mean,
/// amplitude and phase of each arm, counted from 0 (empty beyond a swimmer's last).
class CycleTable {
 public:
  /// @param end  where to continue the table of a run that was interrupted; absent: starts a new one
  /// @throws StorageError if the file cannot be written
  CycleTable(const std::string& path, const std::vector<Group>& groups, const FluidCase& fluid, double step_s,
             const std::optional<TableEnd>& end);

  void add(const Group& group, const Cycle& cycle);
  TableEnd sync() { return file_.sync(); }

 private:
  const FluidCase& fluid_;
  double step_s_;
  std::int64_t most_arms_;
  CsvFile file_;
};

}  // namespace copepod::coupler
