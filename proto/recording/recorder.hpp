#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "conversion/record_encoder.hpp"
#include "recording/record_file.hpp"

namespace copepod::recording {

using Clock = std::chrono::steady_clock;

/// Nanoseconds of the clock that all recordings of this machine share.
std::uint64_t nanoseconds(Clock::time_point time);

/// A recording of this process: a file with schema and header, and what is appended. Used by one thread.
class Recorder {
 public:
  /// @param process  "coupler", "fluid" or "body"
  /// @throws StorageError if the file exists or cannot be made
  Recorder(const std::string& path, const std::string& process, int rank);

  void add_phase(std::string_view name, std::int64_t step, Clock::time_point begin, Clock::time_point end) {
    file_.append(encoder_.encode_phase(name, step, nanoseconds(begin), nanoseconds(end) - nanoseconds(begin)));
  }
  void add_message(const conversion::MessageLabel& label, std::span<const std::byte> envelope) {
    file_.append(encoder_.encode_head(label, envelope.size()), envelope);
  }

  /// Why recording stopped early; empty if it did not.
  [[nodiscard]] std::string problem() { return file_.problem(); }

 private:
  conversion::RecordEncoder encoder_;
  RecordFile file_;
};

}  // namespace copepod::recording
