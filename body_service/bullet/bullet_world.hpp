#pragma once

#include <memory>

#include "engine/engine_world.hpp"

namespace copepod::body {

/// The bodies, springs and walls of a case in Bullet.
///
/// Bullet keeps the contacts and the order of neighbours of former steps. Here every step starts from a fresh
/// world made of the state alone, so that the next state is a function of state and loads: a restart gives
/// the same bits.
/// @throws CaseError naming the body if a mesh is concave, or if a wall moves
std::unique_ptr<EngineWorld> make_bullet_world(const BodySetup& setup, const BodyModel& model, double step_s);

}  // namespace copepod::body
