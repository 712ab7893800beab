#pragma once

#include <array>
#include <cstddef>
#include <optional>
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

using Bytes = std::span<const std::byte>;

/// The messages of every step hold nothing but arrays: fields 1, 2, … of type `repeated double`. On the wire
/// each is a tag, its length in bytes, and the numbers as they lie in memory [Protocol Buffers, "Encoding"],
/// so they are written to the wire and read from it in place, without a message object in between.
inline constexpr std::size_t kMostArrays = 7;

using Arrays = std::array<std::span<const double>, kMostArrays>;  ///< field 1 first; unused ones are empty

/// Bytes that an Envelope needs for its field `message` with these arrays.
std::size_t size_of_arrays(int message, const Arrays& arrays);

/// Writes that field, `size_of_arrays` bytes.
void write_arrays(int message, const Arrays& arrays, std::byte* target);

/// Where a message of arrays lies in the bytes of its Envelope; the numbers need not be aligned.
struct ArraysOnWire {
  int message = 0;        ///< number of the Envelope's field
  std::size_t begin = 0;  ///< of that field; before it is the header
  std::array<Bytes, kMostArrays> arrays{};
};

/// @param envelope  without its checksum
/// @return nothing for all other messages, among them those that hold the same in one of the rarer ways that
///         Protobuf allows (arrays in pieces or unpacked, fields in another order or unknown): for its parser
std::optional<ArraysOnWire> find_arrays(Bytes envelope);

}  // namespace copepod::conversion
