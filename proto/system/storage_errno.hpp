#pragma once

#include <cerrno>

namespace copepod {

/// Whether an error's number means that a disk takes no more: full, out of inodes or quota, read-only or broken.
inline bool is_storage_errno(int error) { return error == ENOSPC || error == EDQUOT || error == EROFS || error == EIO; }

}  // namespace copepod
