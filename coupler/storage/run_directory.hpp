#pragma once

#include <filesystem>
#include <string>

namespace copepod::coupler {

/// The folder that a run writes to, and where things lie in it (docs: "The run directory").
class RunDirectory {
 public:
  /// Creates the folder and logs/ in it if they are missing.
  /// @throws StorageError if that fails
  explicit RunDirectory(const std::filesystem::path& root);

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path resolved_case() const { return root_ / "case.yaml"; }
  [[nodiscard]] std::filesystem::path provenance() const { return root_ / "provenance.json"; }
  [[nodiscard]] std::filesystem::path trajectory_csv() const { return root_ / "trajectory.csv"; }
  [[nodiscard]] std::filesystem::path trajectory_hdf5() const { return root_ / "trajectory.h5"; }
  /// @param suffix  that of the trajectory
  [[nodiscard]] std::filesystem::path obstacles(const std::filesystem::path& suffix) const {
    return (root_ / "obstacles").replace_extension(suffix);
  }
  [[nodiscard]] std::filesystem::path bodies() const { return root_ / "bodies.pvd"; }
  [[nodiscard]] std::filesystem::path cycles() const { return root_ / "cycles.csv"; }
  [[nodiscard]] std::filesystem::path checkpoints() const { return root_ / "checkpoints"; }
  [[nodiscard]] std::filesystem::path summary() const { return root_ / "summary.json"; }

  /// A file for the messages of this attempt that does not exist yet: wire/attempt_001.rec, …
  /// @throws StorageError if wire/ cannot be made
  [[nodiscard]] std::filesystem::path new_wire_file() const;
  /// A new folder for the phases of this attempt: trace/attempt_001, …
  /// @throws StorageError
  [[nodiscard]] std::filesystem::path new_trace_folder() const;

 private:
  std::filesystem::path root_;  ///< absolute
};

}  // namespace copepod::coupler
