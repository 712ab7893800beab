#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contract/body_setup.hpp"
#include "engine/engine_world.hpp"

struct mjModel_;
struct mjData_;

namespace copepod::body {

using MujocoModel = std::unique_ptr<mjModel_, void (*)(mjModel_*)>;
using MujocoData = std::unique_ptr<mjData_, void (*)(mjData_*)>;

/// MuJoCo's form of a model. Errors inside the library become SolverError from here on.
/// @param model_file  what `mjcf` includes as "model.xml"; empty: nothing
/// @throws CaseError with MuJoCo's words if it refuses the text
MujocoModel compiled(const std::string& mjcf, const std::string& model_file = "");

MujocoData new_data(const mjModel_& model);

/// A sphere or capsule of a model, number `geom` of MuJoCo's, as a body of a case.
struct ModelBody {
  int geom = 0;
  BodySpecification body;
};

/// The spheres and capsules of a model, in its order and in its initial position; planes are left out. Those that hang
/// on the world are fixed. The mass of a body of several geoms is shared out by volume.
/// @throws CaseError if there are other geoms, or none
std::vector<ModelBody> bodies_of(const mjModel_& mujoco, const ModelSpecification& model);

/// The same as sections of a case in JSON: `bodies`, and `joints` between those that MuJoCo lets overlap (geoms of one
/// body, of a body and the one that it hangs on, and those that the model excludes); and the names of its actuators.
/// @throws CaseError if MuJoCo refuses the model, or it reads other files
std::string bodies_as_json(const ModelSpecification& model);

/// @throws CaseError if the bodies of the setup are not those of its model
void require_bodies_of_model(const BodySetup& setup, const std::vector<ModelBody>& bodies);

/// @throws CaseError if the text is empty, or names files, which would not be part of the case
void require_no_files(const std::string& mjcf);

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

/// The bodies and joints of a case, or its model, in MuJoCo. Each body of the case is a geom of MuJoCo's, of which
/// several can be one rigid body.
///
/// MuJoCo carries nothing from step to step but the coordinates and velocities of its trees and the states of its
/// actuators: its constraint solver starts afresh, so that a restart gives the same bits.
/// @throws CaseError if MuJoCo cannot represent the case
std::unique_ptr<EngineWorld> make_mujoco_world(const BodySetup& setup, const BodyModel& model, double step_s);

}  // namespace copepod::body
