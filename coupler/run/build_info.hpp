#pragma once

#include <string>

namespace copepod::coupler {

/// What this program was built from and with.
struct BuildInfo {
  std::string version;
  std::string git_revision;  ///< with "-dirty" if the tree had changes; "unknown" outside a checkout
  std::string compiler;
  std::string build_type;
};

const BuildInfo& build_info();

}  // namespace copepod::coupler
