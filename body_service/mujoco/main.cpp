#include "component/run_component.hpp"
#include "contract/features.hpp"
#include "engine/engine_body_solver.hpp"
#include "mujoco/mujoco_world.hpp"

int main(int argc, char** argv) {
  using namespace copepod;
  const Capabilities capabilities{
      "MuJoCo rigid bodies", COPEPOD_VERSION,
      features_in(
          "shape:sphere shape:capsule shape:ellipsoid shape:cylinder shape:box shape:compound inertia "
          "motion:free motion:fixed motion:axis springs anchors bends joint:ball joint:hinge joint:slider "
          "joint:fixed joint:distance joint:model joint:springs joint:limits actuator:pair_force "
          "actuator:body_force actuator:body_torque actuator:world_force actuator:world_torque "
          "actuator:joint_motion actuator:control model:mjcf gravity contact contacts walls checkpoint snapshots")};
  return run_body_component(argc, argv,
                            {capabilities,
                             [&](const auto& setup, auto& context) {
                               return std::make_unique<body::EngineBodySolver>("MuJoCo", body::make_mujoco_world, setup,
                                                                               &context);
                             },
                             // Measured with Debian 12 [docs/results/memory.md]; some hundred bodies fit into that.
                             [](const auto&, int) {
                               return Estimate{std::int64_t{16} << 20, ""};
                             },
                             body::bodies_as_json});
}
