#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "contract/errors.hpp"

namespace copepod::conversion {

/// What a message may hold at most. Far above any run, far below what would exhaust a machine.
struct Limits {
  std::size_t message_bytes = std::size_t{256} << 20;
  std::size_t hello_bytes = std::size_t{64} << 10;  ///< before the token has been checked
  std::size_t list_entries = 1'000'000;             ///< of bodies, springs and every other list of a setup
  double cells = 1e12;                              ///< so many times the bytes of a cell are still a 64-bit number
  std::size_t driving_nodes = 16;
  std::size_t string_bytes = 4096;
  std::size_t model_bytes = std::size_t{16} << 20;  ///< text of BodySetup::model
  std::size_t features = 1024;
};

inline constexpr Limits kLimits{};

/// Bytes that are not a message of the protocol, or a message whose shapes, sizes or numbers are not valid.
class MalformedMessage : public Error {
 public:
  explicit MalformedMessage(const std::string& problem)
      : Error(ExitCode::refused,
              "A message was refused (" + problem + "). Use the same protocol version on both sides."),
        problem_(problem) {}

  /// What is wrong, as part of a sentence.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  std::string problem_;
};

/// A message whose numbers are infinite or NaN: the sender's solver has diverged.
class NotFinite final : public MalformedMessage {
 public:
  using MalformedMessage::MalformedMessage;
};

/// Bytes whose checksum does not fit: they changed or got lost on their way, so neither their sender nor
/// their content is known. To be treated like a message that did not arrive.
class DamagedMessage final : public MalformedMessage {
 public:
  explicit DamagedMessage(std::size_t bytes)
      : MalformedMessage(std::to_string(bytes) + " bytes do not end with their checksum") {}
};

/// A text that may travel: cut at `limit` bytes, and every byte that is not part of valid UTF-8 replaced by
/// '?'. Protocol Buffers refuse other bytes, and the message of a failing solver must not
/// be lost for its encoding.
std::string as_utf8(std::string_view text, std::size_t limit);

}  // namespace copepod::conversion
