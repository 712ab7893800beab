#pragma once

#include <string>

namespace copepod::fluid {

/// Checkpoint of a solver without state: a file that only says whose it is, so that a resumed run notices
/// another solver's.
/// @param solver  "vacuum", "stokes"
/// @throws StorageError
void save_stateless(const std::string& path, const std::string& solver);

/// @throws StorageError if the file is missing, damaged or of another solver
void restore_stateless(const std::string& path, const std::string& solver);

}  // namespace copepod::fluid
