#include <csignal>
#include <iostream>

#include "local_components.hpp"
#include "run/program.hpp"

int main(int argc, char** argv) {
  using namespace copepod;
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a full disk, not the end
  return coupler::run_program(argc, argv, std::cout, std::cerr,
                              [](const auto&, const coupler::ServicesCase& services, const auto&) {
                                return std::make_unique<LocalComponents>(services.fluid_ranks);
                              });
}
