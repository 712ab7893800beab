#include <csignal>
#include <iostream>
#include <iterator>
#include <string>

#include <nlohmann/json.hpp>

#include "conversion/codec.hpp"
#include "local_components.hpp"
#include "run/program.hpp"
#include "service/rank_solver.hpp"

using namespace copepod;

namespace {

/// `--estimate --ranks N`, as a service answers it: what each rank adds to the memory of the process, for the fluid's
/// setup on standard input.
int print_estimate(int ranks) {
  const std::string setup{std::istreambuf_iterator<char>(std::cin), {}};
  try {
    const std::int64_t bytes = fluid::rank_bytes(conversion::fluid_setup_from_bytes(setup), ranks);
    std::cout << nlohmann::json{{"memory_bytes", bytes}, {"problem", ""}}.dump() << std::endl;
    return static_cast<int>(ExitCode::finished);
  } catch (const Error& error) {
    std::cerr << "error: " << error.what() << std::endl;
    return static_cast<int>(error.code());
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && argv[1] == std::string("--estimate")) return print_estimate(std::atoi(argv[3]));
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is a full disk, not the end
  return coupler::run_program(argc, argv, std::cout, std::cerr,
                              [](const auto&, const coupler::Case& the_case, const auto&) {
                                return std::make_unique<LocalComponents>(the_case.services.fluid_ranks);
                              });
}
