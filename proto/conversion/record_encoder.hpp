#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "session/role.hpp"

namespace copepod::conversion {

/// Whose recording it is, and what its times mean; fields as in recording.proto.
struct RecordingHeader {
  std::string process;
  int rank = 0;
  std::string host;
  std::string clock;
  std::uint64_t monotonic_ns = 0;
  std::uint64_t utc_ns = 0;
};

enum class Direction { to_component, from_component };

/// Everything about a recorded message but its bytes.
struct MessageLabel {
  std::uint64_t time_ns = 0;
  Direction direction = Direction::to_component;
  std::optional<session::Role> role;  ///< absent: unknown
  std::optional<session::Lane> lane;
};

/// Turns what a recording holds into the bytes of a copepod.v1.Record. Bytes stay valid until the next call;
/// nothing is allocated per record.
class RecordEncoder {
 public:
  using Bytes = std::span<const std::byte>;

  RecordEncoder();
  RecordEncoder(const RecordEncoder&) = delete;
  RecordEncoder& operator=(const RecordEncoder&) = delete;
  ~RecordEncoder();

  Bytes encode(const RecordingHeader& header);
  Bytes encode_phase(std::string_view name, std::int64_t step, std::uint64_t begin_ns, std::uint64_t duration_ns);

  /// The beginning of the record of a message; its end are the message's `size` bytes themselves.
  Bytes encode_head(const MessageLabel& label, std::size_t size);

 private:
  struct Buffers;
  Bytes serialise();
  std::unique_ptr<Buffers> buffers_;
};

/// The schema of recordings and of all messages: a google.protobuf.FileDescriptorSet, imported files first.
std::vector<std::byte> recording_schema();

}  // namespace copepod::conversion
