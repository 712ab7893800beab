#pragma once

#include <cstdint>

#include "config/sections/case.hpp"

namespace copepod::coupler {

/// Peak resident memory of the processes of a run [bytes]; 0 for a component that is not ours.
struct MemoryEstimate {
  std::int64_t fluid_rank = 0;  ///< of the largest rank
  int fluid_ranks = 0;
  std::int64_t body = 0;
  std::int64_t coupler = 0;

  [[nodiscard]] std::int64_t total() const { return fluid_ranks * fluid_rank + body + coupler; }
};

/// What our services will need:
///   lattice rank: B + (19 w + 4) n_ghost + 800 n_face + H + 36 k n,   others: B
/// with n cells of the rank's block, n_face those on faces to other ranks, n_ghost those with ghost layer and
/// padding of rows, w bytes per number, 4 bytes for the body that covers a cell, and k copies of the fields
/// (density, velocity, body: 36 bytes) while they are written: 2 for a snapshot, 3 for a mean. H is HDF5 in
/// cases with fields or checkpoints by steps; checkpoints need no copy of the populations. B is what a
/// process of each kind has before the case: libraries, MPI, sockets. Known to 10 % by the measurements in
/// docs/results/memory.md, which tests/integration/memory_test.py repeats.
MemoryEstimate estimate_memory(const Case& the_case);

}  // namespace copepod::coupler
