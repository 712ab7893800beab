#pragma once

#include <functional>
#include <memory>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"
#include "contract/capabilities.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"

namespace copepod {

/// A fluid solver together with what it can do: all that `run_fluid_component` needs to make a service of it.
struct FluidComponent {
  Capabilities capabilities;
  std::function<std::unique_ptr<FluidSolver>(const FluidSetup&)> make_solver;
};

/// The same for bodies.
struct BodyComponent {
  Capabilities capabilities;
  std::function<std::unique_ptr<BodySolver>(const BodySetup&)> make_solver;
};

}  // namespace copepod
