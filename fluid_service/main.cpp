#include "communication/mpi_session.hpp"
#include "service/fluid_program.hpp"

int main(int argc, char** argv) {
  copepod::fluid::MpiSession session;
  return session.finish(copepod::fluid::run_fluid_program(argc, argv, session.ranks()));
}
