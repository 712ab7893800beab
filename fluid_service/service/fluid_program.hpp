#pragma once

#include "ranks/distributed_fluid.hpp"

namespace copepod::fluid {

/// The program of every rank: rank 0 serves the coupler, the others follow rank 0. MPI is started only if
/// the command line starts a service and a launcher (mpirun) started this process: a single process needs none.
/// @param make_solver  each rank's part of the solver
/// @return exit code of the process (contract/errors.hpp)
int run_fluid_program(int argc, char** argv, const RankSolverFactory& make_solver);

}  // namespace copepod::fluid
