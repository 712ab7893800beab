#pragma once

#include <cstdint>
#include <exception>

#include "contract/errors.hpp"

namespace copepod::fluid {

/// What to tell about an exception of rank `rank`; `step` counts where the error does not know its own.
FailureReport failure_of_rank(const std::exception& error, int rank, std::int64_t step);

}  // namespace copepod::fluid
