#pragma once

#include <atomic>
#include <cstdint>

#include "ranks/distributed_fluid.hpp"

namespace copepod::fluid {

/// The loop of every rank but 0: does what rank 0 says until it says stop (Order).
///
/// An exception of this rank is reported to all others; it is thrown on afterwards.
/// @param current_step  set to the step of every exchange, for logs
/// @throws PeerFailed if another rank failed, Error if this one did
void follow(Communicator& communicator, const RankSolverFactory& make_solver,
            std::atomic<std::int64_t>& current_step);

}  // namespace copepod::fluid
