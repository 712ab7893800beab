#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <exception>

#include "contract/errors.hpp"

namespace copepod::fluid {

/// The report of an exception of rank `rank`; `step` is used where the error has none.
FailureReport failure_of_rank(const std::exception& error, int rank, std::int64_t step);

/// A failure report as one message of fixed size, small enough to be sent without a handshake.
struct FailurePacket {
  ExitCode code = ExitCode::solver_failed;
  int rank = 0;
  std::int64_t step = -1;
  std::array<char, 65> component{};  ///< each text ends with a zero
  std::array<char, 257> host{};
  std::array<char, 1601> reason{};
};

/// @param report  its texts are cut to what fits
FailurePacket pack_failure(const FailureReport& report);
FailureReport unpack_failure(const FailurePacket& packet);

}  // namespace copepod::fluid
