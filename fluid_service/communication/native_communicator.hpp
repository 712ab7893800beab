#pragma once

#include <mpi.h>

#include "communication/communicator.hpp"

namespace copepod::fluid {

/// The MPI communicator behind `communicator`, for parallel HDF5 only; MPI_COMM_SELF for a SelfCommunicator.
///
/// Waits inside HDF5 are blocking and do not see failure reports, so code between two HDF5 calls must not
/// throw on one rank alone: collect the error and agree on it afterwards (output/collective_status.hpp).
MPI_Comm native_communicator(const Communicator& communicator);

}  // namespace copepod::fluid
