#include "component/run_component.hpp"
#include "components.hpp"
#include "fake_arguments.hpp"

/// A body component of free point masses, with defects chosen on its command line.
int main(int argc, char** argv) {
  using namespace copepod;
  doubles::FakeArguments arguments(argc, argv);
  const auto component = misbehaving(doubles::free_point_component(), arguments.misbehaviour());
  return run_body_component(arguments.argc(), arguments.argv(), component);
}
