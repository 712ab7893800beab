#include "transport/frame.hpp"

#include <cstring>

namespace copepod::transport {

void fill(Frame& frame, const void* data, std::size_t size) {
  if (frame.buffer.size() < size) frame.buffer.resize(size);
  if (size > 0) std::memcpy(frame.buffer.data(), data, size);
  frame.size = size;
}

}  // namespace copepod::transport
