#include <bit>
#include <cstdint>
#include <cstring>

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include "conversion/codec.hpp"
#define XXH_INLINE_ALL  // the kit's users need no library for it
#include <xxhash.h>

#include "copepod/v1/envelope.pb.h"

namespace copepod::conversion {

namespace {

using Checksum = std::array<std::byte, kChecksumBytes>;

constexpr std::byte kTag{(15 << 3) | 1};  ///< field 15, fixed64 [Protocol Buffers, "Encoding"]

Checksum checksum_of(std::span<const std::byte> content) {
  static_assert(std::endian::native == std::endian::little, "packed doubles travel as they lie in memory");
  const std::uint64_t hash = XXH3_64bits(content.data(), content.size());
  Checksum checksum{kTag};
  std::memcpy(checksum.data() + 1, &hash, sizeof(hash));
  return checksum;
}

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;
using google::protobuf::io::CodedOutputStream;

std::uint32_t tag_of(int field) { return WireFormatLite::MakeTag(field, WireFormatLite::WIRETYPE_LENGTH_DELIMITED); }

bool has_length(std::uint32_t tag) {
  return WireFormatLite::GetTagWireType(tag) == WireFormatLite::WIRETYPE_LENGTH_DELIMITED;
}

/// Tag and length.
std::size_t size_of_head(int field, std::size_t length) {
  return CodedOutputStream::VarintSize32(tag_of(field)) + CodedOutputStream::VarintSize64(length);
}

std::uint8_t* write_head(int field, std::size_t length, std::uint8_t* target) {
  target = CodedOutputStream::WriteTagToArray(tag_of(field), target);
  return CodedOutputStream::WriteVarint64ToArray(length, target);
}

/// As Protobuf does, fields without numbers are left out.
std::size_t length_of(const Arrays& arrays) {
  std::size_t length = 0;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const std::size_t bytes = arrays[i].size_bytes();
    if (bytes > 0) length += size_of_head(static_cast<int>(i) + 1, bytes) + bytes;
  }
  return length;
}

bool holds_arrays(int message) {
  return message == v1::Envelope::kKinematicsFieldNumber || message == v1::Envelope::kLoadsFieldNumber ||
         message == v1::Envelope::kAppliedLoadsFieldNumber || message == v1::Envelope::kObservationFieldNumber ||
         message == v1::Envelope::kActionFieldNumber;
}

/// What follows in `stream` is the length of a part of `bytes`, and that part.
std::optional<Bytes> next_part(CodedInputStream& stream, Bytes bytes) {
  int length = 0;
  if (!stream.ReadVarintSizeAsInt(&length)) return std::nullopt;
  const auto begin = static_cast<std::size_t>(stream.CurrentPosition());
  if (!stream.Skip(length)) return std::nullopt;
  return bytes.subspan(begin, length);
}

CodedInputStream stream_of(Bytes bytes) {
  return CodedInputStream(reinterpret_cast<const std::uint8_t*>(bytes.data()), static_cast<int>(bytes.size()));
}

/// False unless `content` is at most one array of each field, in their order.
bool find_arrays_inside(Bytes content, std::array<Bytes, kMostArrays>& arrays) {
  CodedInputStream stream = stream_of(content);
  std::size_t next = 0;
  while (const std::uint32_t tag = stream.ReadTag()) {
    const auto index = static_cast<std::size_t>(WireFormatLite::GetTagFieldNumber(tag)) - 1;
    if (!has_length(tag) || index < next || index >= arrays.size()) return false;
    const auto array = next_part(stream, content);
    if (!array || array->size() % sizeof(double) != 0) return false;
    arrays[index] = *array;
    next = index + 1;
  }
  return stream.ConsumedEntireMessage();
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

std::size_t size_of_arrays(int message, const Arrays& arrays) {
  const std::size_t length = length_of(arrays);
  return size_of_head(message, length) + length;
}

void write_arrays(int message, const Arrays& arrays, std::byte* target) {
  auto* end = write_head(message, length_of(arrays), reinterpret_cast<std::uint8_t*>(target));
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const std::size_t bytes = arrays[i].size_bytes();
    if (bytes == 0) continue;
    end = write_head(static_cast<int>(i) + 1, bytes, end);
    std::memcpy(end, arrays[i].data(), bytes);
    end += bytes;
  }
}

std::optional<ArraysOnWire> find_arrays(Bytes envelope) {
  CodedInputStream stream = stream_of(envelope);
  for (;;) {
    ArraysOnWire found;
    found.begin = static_cast<std::size_t>(stream.CurrentPosition());
    const std::uint32_t tag = stream.ReadTag();
    if (tag == 0) return std::nullopt;
    if (!has_length(tag)) {  // a field of the header
      if (!WireFormatLite::SkipField(&stream, tag)) return std::nullopt;
      continue;
    }
    found.message = WireFormatLite::GetTagFieldNumber(tag);
    if (!holds_arrays(found.message)) return std::nullopt;
    const auto content = next_part(stream, envelope);
    const bool is_last = static_cast<std::size_t>(stream.CurrentPosition()) == envelope.size();
    if (!content || !is_last || !find_arrays_inside(*content, found.arrays)) return std::nullopt;
    return found;
  }
}

}  // namespace copepod::conversion
