#include "conversion/seal.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>

#include "conversion/vector_passes.hpp"

namespace copepod::conversion {

namespace {

using Seal = std::array<std::byte, kSealBytes>;

constexpr std::byte kTag{(15 << 3) | 1};  ///< field 15, fixed64 [Protocol Buffers, "Encoding"]

Seal seal_of(std::span<const std::byte> content) {
  static_assert(std::endian::native == std::endian::little, "packed doubles travel as they lie in memory");
  const std::uint64_t hash = vector_passes().hash(content.data(), content.size());
  Seal seal{kTag};
  std::memcpy(seal.data() + 1, &hash, sizeof(hash));
  return seal;
}

}  // namespace

void seal(std::span<std::byte> message) {
  const Seal bytes = seal_of(message.first(message.size() - kSealBytes));
  std::memcpy(message.last(kSealBytes).data(), bytes.data(), kSealBytes);
}

bool is_intact(std::span<const std::byte> message) {
  if (message.size() < kSealBytes) return false;
  const Seal bytes = seal_of(message.first(message.size() - kSealBytes));
  return std::memcmp(message.last(kSealBytes).data(), bytes.data(), kSealBytes) == 0;
}

}  // namespace copepod::conversion
