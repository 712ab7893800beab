#pragma once

#include <cstddef>
#include <span>

namespace copepod::conversion {

/// A message ends with its seal: the Envelope's field 15, one tag byte (0x79) and the XXH3 hash (64 bits,
/// seed 0, little-endian) of all bytes before the tag. Any Protobuf parser reads over it; who checks it can
/// tell a message that changed or lost bytes on its way from one that is wrong.
inline constexpr std::size_t kSealBytes = 9;

/// Writes the seal into the last `kSealBytes` bytes of `message`, which must have as many.
void seal(std::span<std::byte> message);

/// Whether the last bytes are the seal of what is before them.
bool is_intact(std::span<const std::byte> message);

}  // namespace copepod::conversion
