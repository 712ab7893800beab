#pragma once

#include <cstdint>

#include "contract/body_setup.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Digest of everything in a setup that decides how a state evolves; initial states do not enter.
std::uint64_t case_digest(const BodySetup& setup);

/// Digest of the complete state of all bodies before step `step`; equal digests mean equal bits.
std::uint64_t state_digest(std::int64_t step, const MotionState& state);

}  // namespace copepod::body
