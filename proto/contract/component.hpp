#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "contract/body_setup.hpp"
#include "contract/capabilities.hpp"
#include "contract/controller.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "contract/solver_context.hpp"

namespace copepod {

/// What a component predicts about a setup before a run (`--estimate`).
struct Estimate {
  std::int64_t memory_bytes = 0;  ///< of each process
  std::string problem;            ///< a warning for the user; empty: none
};

/// A solver together with what it can do: all that `run_fluid_component` or its like needs to make it a service.
template <class Setup, class Solver>
struct Component {
  Capabilities capabilities;  ///< what it announces
  /// The context outlives the solver.
  std::function<std::unique_ptr<Solver>(const Setup&, SolverContext&)> make_solver;
  /// Optional; announced as feature "estimate". Must be quick and allocate little.
  /// @throws CaseError if so many ranks cannot handle the setup
  std::function<Estimate(const Setup&, int ranks)> estimate = {};
  /// Of body components that announce "model:mjcf": the spheres and capsules of a model as `bodies` of a case, and as
  /// `joints` which of them may overlap, in JSON; and as `controls` the names of its actuators.
  /// @throws CaseError if it cannot be used
  std::function<std::string(const ModelSpecification&)> bodies_of = {};
};

using FluidComponent = Component<FluidSetup, FluidSolver>;           ///< for `run_fluid_component`
using BodyComponent = Component<BodySetup, BodySolver>;              ///< for `run_body_component`
using ControllerComponent = Component<ControllerSetup, Controller>;  ///< for `run_controller_component`

}  // namespace copepod
