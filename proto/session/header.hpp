#pragma once

#include <cstdint>

namespace copepod::session {

/// Protocol version of this build. Minor versions only add fields and messages.
inline constexpr std::uint32_t kProtocolMajor = 2;
inline constexpr std::uint32_t kProtocolMinor = 0;

/// Everything of an Envelope but its body; the fields are documented in envelope.proto.
struct Header {
  std::uint32_t protocol_major = kProtocolMajor;
  std::uint32_t protocol_minor = kProtocolMinor;
  std::uint64_t session_id = 0;
  std::uint64_t epoch = 0;
  std::uint64_t sequence = 0;
  std::uint32_t attempt = 0;
  std::int64_t step = -1;

  /// The same for a message about another step.
  [[nodiscard]] Header at(std::int64_t other_step) const {
    Header header = *this;
    header.step = other_step;
    return header;
  }

  bool operator==(const Header&) const = default;
};

}  // namespace copepod::session
