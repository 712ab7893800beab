#include "service/fluid_program.hpp"
#include "service/rank_solver.hpp"

int main(int argc, char** argv) {
  using namespace copepod::fluid;
  return run_fluid_program(argc, argv, make_rank_solver);
}
