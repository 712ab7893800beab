#pragma once

#include <cerrno>
#include <string>

namespace copepod {

/// Whether an error's number means that a disk takes no more: full, out of inodes or quota, read-only or broken.
inline bool is_storage_errno(int error) { return error == ENOSPC || error == EDQUOT || error == EROFS || error == EIO; }

/// What to do about a file that cannot be written: `usual`, unless it is a limit of the process or the machine.
inline std::string remedy_for(int error, const std::string& usual) {
  if (error == EFBIG) return "Raise the limit of the size of files (ulimit -f).";
  return error == EMFILE || error == ENFILE ? "Raise the limit of open files (ulimit -n)." : usual;
}

}  // namespace copepod
