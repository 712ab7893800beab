#include "component/run_component.hpp"
#include "components.hpp"
#include "fake_arguments.hpp"
#include "halt.hpp"
#include "misbehaviour.hpp"

/// A fluid component with Stokes drag, which misbehaves or halts if its command line asks for it.
int main(int argc, char** argv) {
  using namespace copepod;
  doubles::FakeArguments arguments(argc, argv);
  const doubles::Halt& halt = arguments.halt();
  const auto inner = misbehaving(doubles::constant_drag_component(), arguments.misbehaviour());
  const FluidComponent component = {inner.capabilities, [&](const FluidSetup& setup, SolverContext& context) {
                                      return doubles::halting(inner.make_solver(setup, context), halt, halt.rank,
                                                              context);
                                    }};
  return run_fluid_component(arguments.argc(), arguments.argv(), component);
}
