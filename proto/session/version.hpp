#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "session/header.hpp"

namespace copepod::session {

/// Protocol versions of one side.
struct VersionRange {
  std::uint32_t major = kProtocolMajor;
  std::uint32_t minor_min = 0;
  std::uint32_t minor_max = kProtocolMinor;

  bool operator==(const VersionRange&) const = default;
};

/// Newest minor version of both sides; nothing if there is none.
constexpr std::optional<std::uint32_t> negotiate(const VersionRange& ours, const VersionRange& theirs) {
  if (ours.major != theirs.major) return std::nullopt;
  const std::uint32_t newest = std::min(ours.minor_max, theirs.minor_max);
  const std::uint32_t oldest = std::max(ours.minor_min, theirs.minor_min);
  if (newest < oldest) return std::nullopt;
  return newest;
}

/// "1.0 to 1.3"
inline std::string to_text(const VersionRange& range) {
  const std::string major = std::to_string(range.major) + ".";
  return major + std::to_string(range.minor_min) + " to " + major + std::to_string(range.minor_max);
}

}  // namespace copepod::session
