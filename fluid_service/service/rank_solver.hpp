#pragma once

#include <memory>

#include "contract/capabilities.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/fluid_solver.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// What the fluid service can do: every feature of the case file that one of its solvers honours.
Capabilities capabilities();

/// This rank's part of the solver that the setup asks for.
/// @throws CaseError if the setup asks for a kind of solver that we do not have
std::unique_ptr<FluidSolver> make_rank_solver(const FluidSetup& setup, Communicator& communicator);

}  // namespace copepod::fluid
