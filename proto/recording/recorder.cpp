#include "recording/recorder.hpp"

#include <fstream>

#include "system/host_name.hpp"

namespace copepod::recording {

namespace {

/// Monotonic clocks count from the start of the machine: equal boot ids, comparable times.
std::string clock_name() {
  std::ifstream stream("/proc/sys/kernel/random/boot_id");
  std::string name;
  return std::getline(stream, name) ? name : host_name();
}

conversion::RecordingHeader header_of(const std::string& process, int rank) {
  const auto utc = std::chrono::system_clock::now().time_since_epoch();
  return {process,
          rank,
          host_name(),
          clock_name(),
          nanoseconds(Clock::now()),
          static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(utc).count())};
}

}  // namespace

std::uint64_t nanoseconds(Clock::time_point time) {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count());
}

Recorder::Recorder(const std::string& path, const std::string& process, int rank)
    : file_(path, conversion::recording_schema()) {
  file_.append(encoder_.encode(header_of(process, rank)));
}

}  // namespace copepod::recording
