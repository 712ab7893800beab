#pragma once

#include <string>
#include <string_view>

namespace copepod::conversion {

/// A text that may travel: cut at `limit` bytes, and every byte that is not part of valid UTF-8 replaced by
/// '?'. Protocol Buffers refuse other bytes, and the message of a failing solver must not
/// be lost for its encoding.
std::string as_utf8(std::string_view text, std::size_t limit);

}  // namespace copepod::conversion
