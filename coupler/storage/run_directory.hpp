#pragma once

#include <filesystem>
#include <system_error>

#include <spdlog/fmt/fmt.h>

#include "contract/errors.hpp"

namespace copepod::coupler {

/// The folder that a run writes to, and where things lie in it (docs: "The run directory").
class RunDirectory {
 public:
  /// Creates the folder and logs/ in it if they are missing.
  /// @throws StorageError if that fails
  explicit RunDirectory(const std::filesystem::path& root) : root_(std::filesystem::absolute(root)) {
    make_folder(root_ / "logs");
  }

  [[nodiscard]] const std::filesystem::path& root() const { return root_; }
  [[nodiscard]] std::filesystem::path resolved_case() const { return root_ / "case.yaml"; }
  [[nodiscard]] std::filesystem::path provenance() const { return root_ / "provenance.json"; }
  [[nodiscard]] std::filesystem::path trajectory_csv() const { return root_ / "trajectory.csv"; }
  [[nodiscard]] std::filesystem::path trajectory_npy() const { return root_ / "trajectory.npy"; }
  /// @param suffix  that of the trajectory
  [[nodiscard]] std::filesystem::path obstacles(const std::filesystem::path& suffix) const {
    return (root_ / "obstacles").replace_extension(suffix);
  }
  [[nodiscard]] std::filesystem::path bodies() const { return root_ / "bodies.pvd"; }
  [[nodiscard]] std::filesystem::path cycles() const { return root_ / "cycles.csv"; }
  [[nodiscard]] std::filesystem::path flow() const { return root_ / "flow.csv"; }
  [[nodiscard]] std::filesystem::path coefficients() const { return root_ / "coefficients.csv"; }
  [[nodiscard]] std::filesystem::path checkpoints() const { return root_ / "checkpoints"; }
  [[nodiscard]] std::filesystem::path summary() const { return root_ / "summary.json"; }

  /// A file for the messages of this attempt that does not exist yet: wire/attempt_001.rec, …
  /// @throws StorageError if wire/ cannot be made
  [[nodiscard]] std::filesystem::path new_wire_file() const {
    make_folder(root_ / "wire");
    return first_free(root_ / "wire", ".rec");
  }
  /// A new folder for the phases of this attempt: trace/attempt_001, …
  /// @throws StorageError
  [[nodiscard]] std::filesystem::path new_trace_folder() const {
    const std::filesystem::path folder = first_free(root_ / "trace", "");
    make_folder(folder);
    return folder;
  }

 private:
  static void make_folder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (!error) return;
    throw StorageError(folder.string() + " cannot be created (" + error.message() + "). Choose another --out folder.");
  }

  /// A resumed run finds the recordings of the attempts before it.
  static std::filesystem::path first_free(const std::filesystem::path& folder, const char* extension) {
    for (int attempt = 1;; ++attempt) {
      const std::filesystem::path file = folder / fmt::format("attempt_{:03}{}", attempt, extension);
      if (!std::filesystem::exists(file)) return file;
    }
  }

  std::filesystem::path root_;  ///< absolute
};

}  // namespace copepod::coupler
