#include "transport/lock_file.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "contract/errors.hpp"
#include "system/storage_errno.hpp"

namespace copepod::transport {

namespace {

/// What the file holds: the process id of a coupler, living or dead, or nothing yet.
std::string owner_of(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t size = pread(descriptor, text.data(), text.size() - 1, 0);
  std::string owner(text.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  while (!owner.empty() && owner.back() == '\n') owner.pop_back();
  return owner;
}

bool is_process_id(const std::string& text) {
  return std::ranges::all_of(text, [](unsigned char c) { return std::isdigit(c) != 0; }) && text.size() < 20;
}

[[noreturn]] void throw_full(const std::string& path, int error) {
  throw StorageError("The lock file " + path + " cannot be written (" + std::strerror(error) +
                     "). Free space and inodes on that disk.");
}

}  // namespace

LockFile::LockFile(const std::string& path) : descriptor_(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600)) {
  if (descriptor_ < 0) {
    if (is_storage_errno(errno)) throw_full(path, errno);
    throw Refused("The lock file " + path + " cannot be opened (" + std::strerror(errno) + "). " +
                  remedy_for(errno, "Choose a directory that exists and that you may write."));
  }
  if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    const std::string owner = owner_of(descriptor_);
    close(descriptor_);
    throw Refused("The address is taken (the coupler with process id " + (owner.empty() ? "unknown" : owner) +
                  " holds " + path + "). Wait for it to end, or use another run directory.");
  }
  if (!is_process_id(owner_of(descriptor_))) {
    close(descriptor_);
    throw Refused("The lock file " + path + " cannot be used (it was not written by a coupler). Use another address.");
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  const bool written = ftruncate(descriptor_, 0) == 0 &&
                       pwrite(descriptor_, pid.data(), pid.size(), 0) == static_cast<ssize_t>(pid.size());
  if (!written) {
    const int error = errno;
    close(descriptor_);
    throw_full(path, error);
  }
}

// The file stays: removing it would let a third process lock a new file of the same name beside a second one
// that waits on the old.
LockFile::~LockFile() { close(descriptor_); }

}  // namespace copepod::transport
