#include "files/sync_file.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

#include "contract/errors.hpp"

namespace copepod::fluid {

namespace {

bool synced(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool done = fsync(file) == 0;
  return close(file) == 0 && done;
}

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

}  // namespace

void publish(const std::string& unfinished, const std::string& path) {
  if (!synced(unfinished) || std::rename(unfinished.c_str(), path.c_str()) != 0 || !synced(folder_of(path)))
    throw StorageError(path + " could not be brought to the disk (" + std::strerror(errno) +
                       "). Make room, check the disk, and resume.");
}

}  // namespace copepod::fluid
