#pragma once

#include <algorithm>
#include <string>

namespace copepod {

/// The text with `?` for control characters, line feeds too: it may hold the words of strangers or of files from
/// elsewhere, which must not command a terminal or pass for lines of ours.
inline std::string printable(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
  return text;
}

}  // namespace copepod
