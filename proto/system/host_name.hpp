#pragma once

#include <array>
#include <string>
#include <unistd.h>

namespace copepod {

/// Name of this machine, for reports.
inline std::string host_name() {
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

}  // namespace copepod
