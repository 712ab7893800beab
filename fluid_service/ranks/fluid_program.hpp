#pragma once

#include "contract/component.hpp"
#include "ranks/distributed_fluid.hpp"

namespace copepod::fluid {

/// The program of every rank: rank 0 serves the coupler, the others follow rank 0: each call of the solver is made on
/// all ranks with the same arguments, except that the kinematics are on rank 0 only. Ranks that wait sleep. A rank that
/// throws ends all, except for a StorageError of `save`.
///
/// MPI is started only if the command line starts a service and a launcher (mpirun) started this process: a single
/// process needs none, unless the solver itself does, which starts it then.
/// @param component    capabilities and estimate; its `make_solver` is not used
/// @param make_solver  each rank's part of the solver
/// @return exit code of the process (contract/errors.hpp)
int run_fluid_program(int argc, char** argv, const FluidComponent& component, const RankSolverFactory& make_solver);

}  // namespace copepod::fluid
