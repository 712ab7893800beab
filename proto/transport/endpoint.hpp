#pragma once

#include <cstdint>
#include <string>

namespace copepod::transport {

inline constexpr std::int64_t kLargestMessage = 256LL << 20;  ///< bytes; larger ones break the connection

/// Checks an endpoint before ZeroMQ sees it, so that people read what is wrong.
/// @throws CaseError unless it is ipc:///absolute/path of at most 107 bytes, or tcp://host:port
void check_endpoint(const std::string& endpoint);

/// Whether messages to that endpoint never leave this machine: ipc, or tcp to a loopback address.
bool stays_on_this_machine(const std::string& endpoint);

/// @throws CaseError if other machines could listen and take part
void require_keys_off_this_machine(const std::string& endpoint, bool has_keys);

/// The same with the address of the host in place of its name, IPv4 if it has one, so that both sides use the same one.
/// @throws CaseError if this machine cannot resolve the name
std::string with_numeric_host(const std::string& endpoint);

/// The socket file of an ipc endpoint; empty for others.
std::string ipc_path(const std::string& endpoint);

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
