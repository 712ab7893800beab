#include "component/run_component.hpp"
#include "rigid_body_solver.hpp"

int main(int argc, char** argv) {
  using copepod::body::RigidBodySolver;
  return copepod::run_body_component(
      argc, argv,
      {copepod::body::rigid_body_capabilities(),
       [](const auto& setup, auto& context) { return std::make_unique<RigidBodySolver>(setup, &context); },
       // Measured with Debian 12 [docs/results/memory.md]; some thousand bodies fit into that.
       [](const auto&, int) {
         return copepod::Estimate{std::int64_t{11} << 20, ""};
       }});
}
