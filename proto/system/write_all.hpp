#pragma once

#include <cerrno>
#include <cstddef>
#include <span>
#include <unistd.h>

namespace copepod {

/// Writes all bytes, however many calls that takes.
/// @return false if one failed; errno holds the reason
inline bool write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace copepod
