#pragma once

#include <cstddef>
#include <string>

#include "contract/errors.hpp"

namespace copepod::conversion {

/// Bytes that are no message of the protocol, or a message whose shapes, sizes or numbers make no sense.
class MalformedMessage : public Error {
 public:
  explicit MalformedMessage(const std::string& problem)
      : Error(ExitCode::refused,
              "A message was refused (" + problem + "). Use the same protocol version on both sides.") {}
};

/// Bytes whose seal does not fit: they changed or got lost on their way, so nothing can be said about who
/// sent them or what they were. To be treated like a message that did not arrive.
class DamagedMessage final : public MalformedMessage {
 public:
  explicit DamagedMessage(std::size_t bytes)
      : MalformedMessage(std::to_string(bytes) + " bytes do not end with their checksum") {}
};

}  // namespace copepod::conversion
