#include "component/run_component.hpp"
#include "fake_arguments.hpp"
#include "rigid_body_solver.hpp"

/// The body service, halting at a place given on its command line.
int main(int argc, char** argv) {
  using namespace copepod;
  doubles::FakeArguments arguments(argc, argv);
  const doubles::Halt& halt = arguments.halt();
  doubles::halt_here(halt, "start");
  const BodyComponent component{body::rigid_body_capabilities(), [&](const BodySetup& setup, SolverContext& context) {
                                  doubles::halt_here(halt, "construct", 0, &context);
                                  return doubles::halting(std::make_unique<body::RigidBodySolver>(setup, &context),
                                                          halt, context);
                                }};
  return run_body_component(arguments.argc(), arguments.argv(), component);
}
