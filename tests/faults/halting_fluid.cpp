#include "fake_arguments.hpp"
#include "ranks/fluid_program.hpp"
#include "service/rank_solver.hpp"
#include "system/process.hpp"

/// The fluid service, halting at a place given on its command line.
int main(int argc, char** argv) {
  using namespace copepod;
  doubles::FakeArguments arguments(argc, argv);
  const doubles::Halt& halt = arguments.halt();
  const int rank = launched_rank().value_or(0);
  if (rank == halt.rank) doubles::halt_here(halt, "start");
  const auto make_solver = [&](const FluidSetup& setup, fluid::Communicator& ranks) {
    if (rank == halt.rank) doubles::halt_here(halt, "construct", 0, &ranks.context());
    return doubles::halting(fluid::make_rank_solver(setup, ranks), halt, rank, ranks.context());
  };
  const FluidComponent component{fluid::capabilities(), {}, fluid::estimate};
  return fluid::run_fluid_program(arguments.argc(), arguments.argv(), component, make_solver);
}
