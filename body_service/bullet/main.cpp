#include "bullet/bullet_body_solver.hpp"
#include "component/run_component.hpp"

int main(int argc, char** argv) {
  using copepod::body::BulletBodySolver;
  return copepod::run_body_component(
      argc, argv, {copepod::body::bullet_capabilities(), [](const copepod::BodySetup& setup) {
                     return std::make_unique<BulletBodySolver>(setup);
                   }});
}
