#include "storage/run_directory.hpp"

#include <spdlog/fmt/fmt.h>

#include "contract/errors.hpp"

namespace copepod::coupler {
namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw StorageError(folder.string() + " cannot be created (" + error.message() + "). Choose another --out folder.");
  }
}

/// A resumed run finds the recordings of the attempts before it.
std::filesystem::path first_free(const std::filesystem::path& folder, const char* extension) {
  for (int attempt = 1;; ++attempt) {
    const std::filesystem::path file = folder / fmt::format("attempt_{:03}{}", attempt, extension);
    if (!std::filesystem::exists(file)) return file;
  }
}

}  // namespace

RunDirectory::RunDirectory(const std::filesystem::path& root) : root_(std::filesystem::absolute(root)) {
  make_folder(root_ / "logs");
}

std::filesystem::path RunDirectory::new_wire_file() const {
  make_folder(root_ / "wire");
  return first_free(root_ / "wire", ".rec");
}

std::filesystem::path RunDirectory::new_trace_folder() const {
  const std::filesystem::path folder = first_free(root_ / "trace", "");
  make_folder(folder);
  return folder;
}

}  // namespace copepod::coupler
