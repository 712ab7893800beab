#include "bullet/bullet_body_solver.hpp"
#include "component/run_component.hpp"

int main(int argc, char** argv) {
  using copepod::body::BulletBodySolver;
  return copepod::run_body_component(
      argc, argv,
      {copepod::body::bullet_capabilities(),
       [](const auto& setup, auto& context) { return std::make_unique<BulletBodySolver>(setup, &context); },
       // Measured with Debian 12 [docs/results/memory.md]; some thousand bodies fit into that.
       [](const auto&, int) {
         return copepod::Estimate{std::int64_t{12} << 20, ""};
       }});
}
