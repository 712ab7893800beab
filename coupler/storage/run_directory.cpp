#include "storage/run_directory.hpp"

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <span>
#include <unistd.h>

#include "contract/errors.hpp"
#include "system/write_all.hpp"

namespace copepod::coupler {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, int error) {
  throw StorageError(path.string() + " cannot be written (" + std::strerror(error) +
                     "). Choose another --out folder, or free space.");
}

}  // namespace

void write_atomically(const std::filesystem::path& path, const std::string& content) {
  const std::filesystem::path temporary = path.string() + ".tmp";
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (file < 0) fail(path, errno);
  int error = 0;
  if (!write_all(file, std::as_bytes(std::span(content))) || ::fsync(file) != 0) error = errno;
  if (::close(file) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), path.c_str()) != 0) error = errno;
  if (error == 0) return;
  ::unlink(temporary.c_str());
  fail(path, error);
}

namespace {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) {
    throw StorageError(folder.string() + " cannot be created (" + error.message() +
                       "). Choose another --out folder.");
  }
}

/// A resumed run finds the recordings of the attempts before it.
std::filesystem::path first_free(const std::filesystem::path& folder, const char* extension) {
  for (int attempt = 1;; ++attempt) {
    std::array<char, 32> name{};
    std::snprintf(name.data(), name.size(), "attempt_%03d%s", attempt, extension);
    if (!std::filesystem::exists(folder / name.data())) return folder / name.data();
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
