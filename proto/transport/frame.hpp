#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace copepod::transport {

using Bytes = std::span<const std::byte>;
using Duration = std::chrono::nanoseconds;

/// One message as it arrived. Buffers grow to the largest message and are reused.
struct Frame {
  std::string peer;      ///< who sent it; empty at the component's end, where there is one peer only
  std::string identity;  ///< with keys: the role whose key the sender holds
  std::vector<std::byte> buffer;
  std::size_t size = 0;

  [[nodiscard]] Bytes bytes() const { return {buffer.data(), size}; }
};

/// Copies a message into a frame.
void fill(Frame& frame, const void* data, std::size_t size);

}  // namespace copepod::transport
