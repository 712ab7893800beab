#pragma once

#include <atomic>
#include <future>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

namespace copepod::protocol_test {

/// A program that a test starts; it is killed when the test is over, whatever happened.
class ChildProcess {
 public:
  explicit ChildProcess(const std::vector<std::string>& command);
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  void signal(int number) const;

  /// Exit code, 128 + signal for a killed program, nothing if it still runs after half a minute.
  std::optional<int> wait();

  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
};

/// Raises `stop` once the process has ended. @return its exit code
std::future<std::optional<int>> stop_after(ChildProcess& process, std::atomic<int>& stop);

}  // namespace copepod::protocol_test
