#include <iostream>

#include "local_components.hpp"
#include "run/program.hpp"

int main(int argc, char** argv) {
  return copepod::coupler::run_program(argc, argv, std::cout, std::cerr,
                                       [](const auto&...) { return std::make_unique<copepod::LocalComponents>(); });
}
