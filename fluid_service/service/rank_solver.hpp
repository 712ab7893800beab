#pragma once

#include <cstdint>
#include <memory>

#include "contract/capabilities.hpp"
#include "contract/component.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// What the fluid service can do: every feature of the case file that one of its solvers supports.
Capabilities capabilities();

/// This rank's part of the solver that the setup asks for.
/// @throws CaseError for an unknown kind of solver
std::unique_ptr<FluidSolver> make_rank_solver(const FluidSetup& setup, Communicator& communicator);

/// Memory of the solver on the largest of so many ranks [bytes].
/// @throws CaseError as `estimate`
std::int64_t rank_bytes(const FluidSetup& setup, int ranks);

/// Memory of the largest of so many processes.
/// @throws CaseError if the setup cannot be computed, or not by so many ranks
Estimate estimate(const FluidSetup& setup, int ranks);

}  // namespace copepod::fluid
