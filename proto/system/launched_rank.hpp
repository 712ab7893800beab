#pragma once

#include <cstdlib>
#include <optional>

namespace copepod {

/// Rank of this process according to the launcher of an MPI program (mpirun, srun, …), before MPI is initialised.
/// @return nothing without a launcher
inline std::optional<int> launched_rank() {
  for (const char* variable : {"PMIX_RANK", "PMI_RANK"})
    if (const char* rank = std::getenv(variable)) return std::atoi(rank);
  return std::nullopt;
}

}  // namespace copepod
