#pragma once

#include <cstddef>
#include <string>

#include "contract/errors.hpp"

namespace copepod::conversion {

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

}  // namespace copepod::conversion
