#pragma once

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

}  // namespace copepod::conversion
