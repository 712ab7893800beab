#include "system/durable_file.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <unistd.h>

#include "contract/errors.hpp"

namespace copepod {

namespace {

constexpr std::size_t piece_bytes = 1 << 20;

[[noreturn]] void fail(const std::string& path, int error) {
  throw StorageError(path + " cannot be written (" + std::strerror(error) + "). " +
                     remedy_for(error, "Check that the folder exists, is writable and has free space."));
}

bool write_pieces(int file, std::span<const std::byte> content, const std::function<void()>& on_piece) {
  for (std::size_t done = 0; done < content.size(); done += piece_bytes) {
    if (!write_all(file, done, content.subspan(done, std::min(piece_bytes, content.size() - done)))) return false;
    if (on_piece) on_piece();
  }
  return true;
}

/// Brings a file or the entries of a folder to the disk. @return false if that failed; errno holds the cause
bool synced(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool done = ::fsync(file) == 0;
  const int error = errno;
  ::close(file);
  errno = error;
  return done;
}

/// @param finish  gives the file, complete under its first argument, its name
void write_then(const std::string& path, std::span<const std::byte> content, const std::function<void()>& on_piece,
                const std::function<void(const std::string& unfinished)>& finish) {
  const std::string unfinished = path + ".unfinished";
  const int file = ::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_CLOEXEC, 0644);
  if (file < 0) fail(path, errno);
  int error = write_pieces(file, content, on_piece) ? 0 : errno;
  if (::close(file) != 0 && error == 0) error = errno;
  try {
    if (error != 0) fail(path, error);
    finish(unfinished);
  } catch (const StorageError&) {
    ::unlink(unfinished.c_str());
    throw;
  }
}

}  // namespace

bool write_all(int descriptor, std::uint64_t position, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(position));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return false;
    bytes = bytes.subspan(written);
    position += static_cast<std::uint64_t>(written);
  }
  return true;
}

void publish(const std::string& unfinished, const std::string& path) {
  const auto folder = std::filesystem::absolute(path).parent_path();
  if (!synced(unfinished) || std::rename(unfinished.c_str(), path.c_str()) != 0 || !synced(folder.string()))
    fail(path, errno);
}
void write_durably(const std::string& path, std::span<const std::byte> content, const std::function<void()>& on_piece) {
  write_then(path, content, on_piece, [&](const std::string& unfinished) { publish(unfinished, path); });
}

void write_atomically(const std::string& path, std::string_view text) {
  write_then(path, std::as_bytes(std::span(text)), {}, [&](const std::string& unfinished) {
    if (std::rename(unfinished.c_str(), path.c_str()) != 0) fail(path, errno);
  });
}

void sync_to_disk(const std::string& path) {
  if (!synced(path)) fail(path, errno);
}

}  // namespace copepod
