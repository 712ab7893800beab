#include "bullet/bullet_body_solver.hpp"
#include "component/run_component.hpp"

int main(int argc, char** argv) {
  using copepod::body::BulletBodySolver;
  return copepod::run_body_component(
      argc, argv, {copepod::body::bullet_capabilities(), [](const auto& setup, auto& context) {
                     return std::make_unique<BulletBodySolver>(setup, &context);
                   }});
}
