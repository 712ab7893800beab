#pragma once

#include <string>

namespace copepod::transport {

/// Keeps a second coupler from an ipc path that a living one uses: ZeroMQ would take the path over
/// silently. The kernel drops the lock when its process ends, however it ends, so what a dead coupler left
/// behind does not matter. On a file system without locks there is no such protection; the deploy command, which makes
/// a private folder for each run, warns of it.
class LockFile {
 public:
  /// @throws Refused if a living process holds the lock (its pid is named), the file cannot be made, or one of this
  ///         name holds something else, which stays; StorageError if the disk takes no more
  explicit LockFile(const std::string& path);
  LockFile(const LockFile&) = delete;
  LockFile& operator=(const LockFile&) = delete;
  ~LockFile();

 private:
  int descriptor_;
};

}  // namespace copepod::transport
