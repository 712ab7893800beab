#pragma once

#include "ranks/distributed_fluid.hpp"

namespace copepod::fluid {

/// The program of every rank: rank 0 serves the coupler, the others follow rank 0.
/// @param make_solver  each rank's part of the solver
/// @return exit code of the process (contract/exit_code.hpp)
int run_fluid_program(int argc, char** argv, Communicator& ranks, const RankSolverFactory& make_solver);

}  // namespace copepod::fluid
