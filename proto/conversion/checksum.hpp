#pragma once

#include <cstddef>
#include <span>

namespace copepod::conversion {

/// A message ends with its checksum: the Envelope's field 15, one tag byte (0x79) and the XXH3 hash (64 bits,
/// seed 0, little-endian) of all bytes before the tag. Any Protobuf parser skips it. A check distinguishes a
/// message that was damaged on its way from one that was sent with errors.
inline constexpr std::size_t kChecksumBytes = 9;

/// Writes the checksum into the last `kChecksumBytes` bytes of `message`, which must have as many.
void write_checksum(std::span<std::byte> message);

/// Whether the last bytes are the checksum of those before them.
bool is_intact(std::span<const std::byte> message);

}  // namespace copepod::conversion
