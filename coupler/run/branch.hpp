#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "config/load_case.hpp"

namespace copepod::coupler {

/// Keys of the resolved cases whose values differ: "fluid.cell_size_m" → {"1e-06", "2e-06"}; "none" where one lacks the
/// key. Length of the run, output, services and published figures do not count: a run is continued with others.
using ChangedKeys = std::map<std::string, std::pair<std::string, std::string>>;

ChangedKeys changed_keys(const Case& before, const Case& now);

/// A run is continued with its own case only.
/// @param directory  of the run
/// @throws CaseError that names the keys that differ
void require_same_case(const std::filesystem::path& directory, const Case& now);

/// Where a run begins that starts a changed case from a checkpoint of another run.
struct Branch {
  std::filesystem::path directory;   ///< of the other run
  std::optional<std::int64_t> step;  ///< of the checkpoint; absent: the newest
  std::string case_key;              ///< of the other run's case
  ChangedKeys changed;
};

/// Finds out whether a state of the run in `directory` can be one of this case: bodies, their shapes, lattice and step
/// must be the same.
/// @throws CaseError
Branch plan_branch(const std::filesystem::path& directory, std::optional<std::int64_t> step, const LoadedCase& now);

}  // namespace copepod::coupler
