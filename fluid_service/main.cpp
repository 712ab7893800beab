#include <malloc.h>

#include "ranks/fluid_program.hpp"
#include "service/rank_solver.hpp"

int main(int argc, char** argv) {
  using namespace copepod::fluid;
  mallopt(M_MMAP_THRESHOLD, 4 << 20);  // memory of large arrays returns to the system when they grow or end
  return run_fluid_program(argc, argv, {capabilities(), {}, estimate}, make_rank_solver);
}
