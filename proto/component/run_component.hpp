#pragma once

#include "contract/component.hpp"

namespace copepod {

/// Turns a solver into a service: reads the command line, connects to the coupler, answers it until the run ends.
///
/// Command line: `--endpoint E --session TOKEN [--log-file F] [--log-level L]`; `--capabilities`, which prints the
/// capabilities as JSON; or `--estimate [--ranks N]`, which reads a setup from standard input and prints the
/// component's estimate. The solver is made on, and called from, the calling thread only; a second thread answers the
/// coupler's pings and never touches the solver. Its exceptions become a Failure message.
/// @return exit code of the process (contract/errors.hpp)
int run_fluid_component(int argc, char** argv, const FluidComponent& component);

/// Whether a command line starts a service. If not (`--capabilities`, `--estimate`, `--help`, a mistake), an MPI
/// program calls `run_fluid_component(argc, argv, component)` without MPI_Init, which takes long and can fail; its
/// `make_solver` may then be empty.
bool starts_service(int argc, char** argv);

/// The same for rank 0 of an MPI program; `make_solver` captures what it needs of the communicator.
/// @param ranks    number of processes of the component, for messages to the user
/// @param context  what `make_solver` receives; outlives the call
int run_fluid_component(int argc, char** argv, const FluidComponent& component, int ranks, SolverContext& context);

/// The same for a body solver.
int run_body_component(int argc, char** argv, const BodyComponent& component);

/// The same for a controller; its command line also has `--name NAME`.
int run_controller_component(int argc, char** argv, const ControllerComponent& component);

}  // namespace copepod
