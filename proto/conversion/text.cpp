#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "conversion/limits.hpp"

namespace copepod::conversion {

namespace {

/// Length of the UTF-8 sequence that a text begins with, 0 if it begins with none [RFC 3629, section 4].
std::size_t sequence_length(std::string_view text) {
  const auto lead = static_cast<std::uint8_t>(text[0]);
  if (lead < 0x80U) return 1;
  const auto length = static_cast<std::size_t>(std::countl_one(lead));
  if (length < 2 || length > 4 || length > text.size()) return 0;
  std::uint32_t code = lead & (0x7FU >> length);
  for (const char next : text.substr(1, length - 1)) {
    const auto byte = static_cast<std::uint8_t>(next);
    if ((byte & 0xC0U) != 0x80U) return 0;
    code = code << 6U | (byte & 0x3FU);
  }
  constexpr std::array<std::uint32_t, 5> least = {0, 0, 0x80, 0x800, 0x10000};  // by length: shorter ones hold less
  const bool is_surrogate = code >= 0xD800U && code <= 0xDFFFU;
  return code < least[length] || is_surrogate || code > 0x10FFFFU ? 0 : length;
}

}  // namespace

std::string as_utf8(std::string_view text, std::size_t limit) {
  std::string result;
  while (!text.empty()) {
    const std::size_t length = sequence_length(text);
    const std::string_view next = length == 0 ? "?" : text.substr(0, length);
    if (result.size() + next.size() > limit) break;
    result += next;
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return result;
}

}  // namespace copepod::conversion
