#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "model/motion_state.hpp"

namespace copepod::body {

/// Digest of what a state belongs to: names, shapes and kinds of motion of the bodies, step, integrator.
std::uint64_t layout_digest(const BodySetup& setup);

/// Digest of the complete state of all bodies before step `step`; equal digests mean equal bits.
/// @param memory  what else the solver carries from step to step
std::uint64_t state_digest(std::int64_t step, const MotionState& state, const std::vector<std::uint64_t>& memory = {});

/// Writes a state to a new file, complete and on the disk on return; an interrupted write leaves none.
///
/// Layout, 64-bit little-endian words: magic "COPEBODY", version, case digest, step, bodies, length of the memory; then
/// position (3 words per body), orientation (4), velocity (3) and angular momentum (3), each body by body; the memory;
/// last the digest of all words before.
/// @param on_piece  called after every piece, so that a slow disk is not mistaken for a process that hangs
/// @param memory    what else the solver carries from step to step
/// @throws StorageError
void write_state(const std::string& path, std::uint64_t layout_digest, std::int64_t step, const MotionState& state,
                 const std::function<void()>& on_piece = {}, const std::vector<std::uint64_t>& memory = {});

/// Reads what `write_state` wrote, bit for bit.
/// @param layout_digest  of the present case
/// @param state        must have the case's number of bodies; overwritten
/// @param memory       overwritten; null: the file must hold none
/// @return the step before which the state was saved
/// @throws StorageError if the file is missing, truncated, damaged, of another version or of another case
std::int64_t read_state(const std::string& path, std::uint64_t layout_digest, MotionState& state,
                        const std::function<void()>& on_piece = {}, std::vector<std::uint64_t>* memory = nullptr);

}  // namespace copepod::body
