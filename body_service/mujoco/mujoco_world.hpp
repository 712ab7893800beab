#pragma once

#include <memory>

#include "engine/engine_world.hpp"

namespace copepod::body {

/// The bodies and joints of a case, or its model, in MuJoCo. Each body of the case is a geom of MuJoCo's, of which
/// several can be one rigid body.
///
/// MuJoCo carries nothing from step to step but the coordinates and velocities of its trees and the states of its
/// actuators: its constraint solver starts afresh, so that a restart gives the same bits.
/// @throws CaseError if MuJoCo cannot represent the case
std::unique_ptr<EngineWorld> make_mujoco_world(const BodySetup& setup, const BodyModel& model, double step_s);

}  // namespace copepod::body
