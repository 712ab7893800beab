// One long run of the fakes with disturbed messages: docs/results/wire.md.
//
//   chaos_run [--steps 10000] [--share 0.1] [--seed 1]
//
// Prints what happened to the messages, and ends with 0 if the digests are those of a run without any wire.
#include <chrono>
#include <iostream>

#include <CLI/CLI.hpp>

#include "disturbed_run.hpp"

int main(int argc, char** argv) {
  using namespace copepod;
  chaos::ChaosPlan plan;
  int steps = 10000;
  CLI::App app{"A coupled run with disturbed messages"};
  app.add_option("--steps", steps);
  app.add_option("--share", plan.share)->check(CLI::Range(0.0, 1.0));
  app.add_option("--seed", plan.seed);
  CLI11_PARSE(app, argc, argv);

  try {
    const auto start = std::chrono::steady_clock::now();
    chaos::DisturbedRun disturbed(plan);
    const protocol_test::Digests digests = disturbed.run(steps);
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
    const bool right = digests == protocol_test::digests_of_local_run(steps);
    std::cout << steps << " steps in " << wall.count() << " s, messages: " << disturbed.tell_disturbances()
              << "; digest " << (right ? "right" : "WRONG") << std::endl;
    return right ? 0 : 1;
  } catch (const Error& error) {
    std::cout << "ended with code " << static_cast<int>(error.code()) << ": " << error.what() << std::endl;
    return static_cast<int>(error.code());
  }
}
