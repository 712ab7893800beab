#include "bullet/bullet_world.hpp"
#include "component/run_component.hpp"
#include "contract/features.hpp"
#include "engine/engine_body_solver.hpp"

int main(int argc, char** argv) {
  using namespace copepod;
  const Capabilities capabilities{
      "Bullet rigid bodies", COPEPOD_VERSION,
      features_in("shape:sphere shape:capsule shape:ellipsoid shape:cylinder shape:box shape:mesh shape:compound "
                  "inertia motion:free motion:fixed motion:prescribed motion:axis springs anchors bends "
                  "actuator:pair_force actuator:body_force actuator:body_torque actuator:world_force "
                  "actuator:world_torque gravity contact contact:friction contacts walls checkpoint snapshots")};
  return run_body_component(argc, argv,
                            {capabilities,
                             [&](const auto& setup, auto& context) {
                               return std::make_unique<body::EngineBodySolver>("Bullet", body::make_bullet_world, setup,
                                                                               &context);
                             },
                             // Measured with Debian 12 [docs/results/memory.md]; some thousand bodies fit into that.
                             [](const auto&, int) {
                               return Estimate{std::int64_t{12} << 20, ""};
                             }});
}
