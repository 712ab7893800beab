#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

namespace copepod {

/// Whether an error's number means that a disk takes no more: full, out of inodes or quota, read-only or broken.
inline bool is_storage_errno(int error) { return error == ENOSPC || error == EDQUOT || error == EROFS || error == EIO; }

/// What to do about a file that cannot be written: `usual`, unless it is a limit of the process or the machine.
inline std::string remedy_for(int error, const std::string& usual) {
  if (error == EFBIG) return "Raise the limit of the size of files (ulimit -f).";
  return error == EMFILE || error == ENFILE ? "Raise the limit of open files (ulimit -n)." : usual;
}

/// Writes all bytes at a place of a file, however many calls that takes.
/// @return false if one failed; errno holds the reason
bool write_all(int descriptor, std::uint64_t position, std::span<const std::byte> bytes);

/// Writes a file that is complete and on the disk on return; until then `path` keeps what it held before.
/// @param on_piece  called after every mebibyte, so that a slow disk is not mistaken for a process that hangs
/// @throws StorageError naming the file and the cause; nothing is left beside `path`
void write_durably(const std::string& path, std::span<const std::byte> content,
                   const std::function<void()>& on_piece = {});

inline void write_durably(const std::string& path, std::string_view text) {
  write_durably(path, std::as_bytes(std::span(text)));
}

/// The same without waiting for the disk: `path` always names a complete file, but a machine that loses power may
/// leave it empty until it is synced.
void write_atomically(const std::string& path, std::string_view text);

/// Waits until a file is on the disk.
/// @throws StorageError naming the file and the cause
void sync_to_disk(const std::string& path);

/// Gives a finished file or folder its final name, durably: its content and its name are on
/// the disk on return.
/// @throws StorageError naming the file and the cause
void publish(const std::string& unfinished, const std::string& path);

}  // namespace copepod
