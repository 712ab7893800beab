#pragma once

#include "communication/communicator.hpp"

namespace copepod::fluid {

/// The program of every rank: rank 0 serves the coupler, the others follow rank 0.
/// @return exit code of the process (contract/exit_code.hpp)
int run_fluid_program(int argc, char** argv, Communicator& ranks);

}  // namespace copepod::fluid
