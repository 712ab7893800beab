#pragma once

#include <string>

#include "contract/body_setup.hpp"
#include "engine/engine_world.hpp"

namespace copepod::body {

/// Step of MuJoCo in its units, the default of its models: accelerations are then far above its absolute thresholds.
inline constexpr double mujoco_step = 0.002;

/// Own inertia of coordinates that are driven, in units of the lightest body's.
inline constexpr double mujoco_drive_inertia = 1e9;

/// The bodies, joints and walls of a case as a model of MuJoCo [MuJoCo 2.2, "XML reference"]. Joints make trees, whose
/// motions are MuJoCo's coordinates, so that they are kept exactly; those that close loops become soft equality
/// constraints. The geom of body 3 is called b3, as is its body, and joint 3 j3.
/// @throws CaseError if MuJoCo cannot represent a joint or a wall
std::string mjcf_of(const BodySetup& setup, const EngineUnits& units);

/// The walls of a case, its gravity and its step around the case's own model, which is included as "model.xml".
/// @param step  in units of the model
std::string mjcf_around_model(const BodySetup& setup, const EngineUnits& units, double step);

}  // namespace copepod::body
