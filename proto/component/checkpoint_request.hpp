#pragma once

#include <string>

#include "contract/errors.hpp"
#include "conversion/decoder.hpp"

namespace copepod::component {

/// The path in a Save or Restore.
inline std::string checkpoint_path(const conversion::Decoder& request) {
  session::CheckpointPath path;
  request.read(path);
  return path.path;
}

/// Lets a solver write its state. A full disk is no reason to end: the solver is as it was.
/// @throws what else the solver throws
template <class Solver>
session::Saved save(Solver& solver, const conversion::Decoder& request) {
  try {
    solver.save(checkpoint_path(request));
    return {};
  } catch (const StorageError& error) {
    return {error.what()};
  }
}

}  // namespace copepod::component
