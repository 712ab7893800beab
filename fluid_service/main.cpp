#include "ranks/mpi_session.hpp"
#include "service/fluid_program.hpp"
#include "service/rank_solver.hpp"

int main(int argc, char** argv) {
  using namespace copepod::fluid;
  MpiSession session;
  return session.finish(run_fluid_program(argc, argv, session.ranks(), make_rank_solver));
}
