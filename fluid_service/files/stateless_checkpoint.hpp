#pragma once

#include <string>

namespace copepod::fluid {

/// Checkpoint of a solver without state: a file that only names the solver, so that a resumed run detects the
/// checkpoint of another one.
/// @param solver  "vacuum", "stokes"
/// @throws StorageError
void save_stateless(const std::string& path, const std::string& solver);

/// @throws StorageError if the file is missing, damaged or of another solver
void restore_stateless(const std::string& path, const std::string& solver);

}  // namespace copepod::fluid
