#include "component/run_component.hpp"
#include "components.hpp"
#include "fake_arguments.hpp"

/// A fluid component with Stokes drag, which misbehaves if its command line says so.
int main(int argc, char** argv) {
  using namespace copepod;
  doubles::FakeArguments arguments(argc, argv);
  const auto component = misbehaving(doubles::constant_drag_component(), arguments.misbehaviour());
  return run_fluid_component(arguments.argc(), arguments.argv(), component);
}
