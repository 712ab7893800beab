#include "conversion/checksum.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "conversion/vector_passes.hpp"

namespace copepod::conversion {

namespace {

using Checksum = std::array<std::byte, kChecksumBytes>;

constexpr std::byte kTag{(15 << 3) | 1};  ///< field 15, fixed64 [Protocol Buffers, "Encoding"]

Checksum checksum_of(std::span<const std::byte> content) {
  static_assert(std::endian::native == std::endian::little, "packed doubles travel as they lie in memory");
  const std::uint64_t hash = vector_passes().hash(content.data(), content.size());
  Checksum checksum{kTag};
  std::memcpy(checksum.data() + 1, &hash, sizeof(hash));
  return checksum;
}

}  // namespace

void write_checksum(std::span<std::byte> message) {
  const Checksum bytes = checksum_of(message.first(message.size() - kChecksumBytes));
  std::memcpy(message.last(kChecksumBytes).data(), bytes.data(), kChecksumBytes);
}

bool is_intact(std::span<const std::byte> message) {
  if (message.size() < kChecksumBytes) return false;
  const Checksum bytes = checksum_of(message.first(message.size() - kChecksumBytes));
  return std::memcmp(message.last(kChecksumBytes).data(), bytes.data(), kChecksumBytes) == 0;
}

}  // namespace copepod::conversion
