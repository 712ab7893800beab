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
using FailurePacket = std::array<std::byte, 2048>;

/// @param report  its reason is cut to what fits
FailurePacket pack_failure(FailureReport report);
FailureReport unpack_failure(const FailurePacket& packet);

}  // namespace copepod::fluid
