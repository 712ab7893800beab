#pragma once

#include <string>

#include "conversion/decoder.hpp"

namespace copepod::component {

/// The path in a Save or Restore.
inline std::string checkpoint_path(const conversion::Decoder& request) {
  session::CheckpointPath path;
  request.read(path);
  return path.path;
}

}  // namespace copepod::component
