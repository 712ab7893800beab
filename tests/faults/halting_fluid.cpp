#include <cstdlib>

#include "fake_arguments.hpp"
#include "ranks/mpi_session.hpp"
#include "service/fluid_program.hpp"
#include "service/rank_solver.hpp"

namespace {

/// Before MPI is initialised, the rank comes from mpirun's environment.
int rank_of_this_process() {
  const char* rank = std::getenv("OMPI_COMM_WORLD_RANK");
  return rank == nullptr ? 0 : std::atoi(rank);
}

}  // namespace

/// The fluid service, halting at a place given on its command line.
int main(int argc, char** argv) {
  using namespace copepod;
  doubles::FakeArguments arguments(argc, argv);
  const doubles::Halt& halt = arguments.halt();
  const int rank = rank_of_this_process();
  if (rank == halt.rank) doubles::halt_here(halt, "start");
  fluid::MpiSession session;
  const auto make_solver = [&](const FluidSetup& setup, fluid::Communicator& ranks) {
    if (rank == halt.rank) doubles::halt_here(halt, "construct", 0, &ranks.context());
    return doubles::halting(fluid::make_rank_solver(setup, ranks), halt, rank, ranks.context());
  };
  return session.finish(fluid::run_fluid_program(arguments.argc(), arguments.argv(), session.ranks(), make_solver));
}
