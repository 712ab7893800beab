#include <iostream>

#include "remote/remote_solvers.hpp"
#include "run/program.hpp"

int main(int argc, char** argv) {
  using namespace copepod::coupler;
  return run_program(
      argc, argv, std::cout, std::cerr, [](const Options& options, const Case& the_case, const RunSignals& signals) {
        return std::make_unique<RemoteComponents>(options, the_case, [&signals] { return signals.stop.load(); });
      });
}
