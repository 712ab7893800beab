#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>

namespace copepod::transport {

using Bytes = std::span<const std::byte>;
using Duration = std::chrono::nanoseconds;

/// One message as it arrived. The bytes belong to the end of the lane that received it, until
/// it receives again.
struct Frame {
  std::string peer;      ///< who sent it; empty at the component's end, where there is one peer only
  std::string identity;  ///< with keys: the role whose key the sender holds
  Bytes content;

  [[nodiscard]] Bytes bytes() const { return content; }
};

}  // namespace copepod::transport
