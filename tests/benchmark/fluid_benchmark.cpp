#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "contract/words.hpp"
#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "memory_rates.hpp"
#include "ranks/mpi_communicator.hpp"

// Speed of the fluid alone beside the speed of the memory, under mpirun; prints one JSON object on rank 0.
// Every sample measures the limit and the fluid one after the other, all ranks at once, so that a ratio is
// one of the same moment on a shared machine.

namespace copepod::fluid::benchmark {
namespace {

struct Options {
  std::vector<std::int64_t> domain = {100, 100, 200};
  bool single = false;
  CollisionKind collision = CollisionKind::bgk;
  int samples = 5;
  int steps = 20;
};

FluidSetup closed_box(const Options& options) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = {options.domain[0], options.domain[1], options.domain[2]};
  setup.collision = options.collision;
  setup.precision = options.single ? Precision::single_precision : Precision::double_precision;
  return setup;
}

/// Seconds that the slowest rank needs for `action`, which all ranks begin together.
template <class Action>
double slowest(Communicator& ranks, const Action& action) {
  std::int64_t barrier[1] = {0};
  ranks.sum_to_all(barrier);
  const auto start = std::chrono::steady_clock::now();
  action();
  std::int64_t nanoseconds[1] = {static_cast<std::int64_t>(1e9 * seconds_since(start))};
  ranks.max_to_all(nanoseconds);
  return 1e-9 * static_cast<double>(nanoseconds[0]);
}

template <class T>
nlohmann::json measure(const Options& options, Communicator& ranks) {
  const FluidSetup setup = closed_box(options);
  LatticeBoltzmann<T> fluid(setup, ranks);
  fluid.initialise([](const Cell& cell) {
    return LocalFlow{0.0, {0.0, 0.0, 1e-3 * static_cast<double>(cell[0] % 7)}};
  });
  const BlockPartition partition(fluid.domain().cells(), ranks.size());
  const PopulationLayout layout(partition.block(ranks.rank()), sizeof(T));
  HugeArray<T> streams(static_cast<std::size_t>(layout.values()));
  HugeArray<double> source(std::size_t{4} << 20);
  HugeArray<double> target(source.size());

  Kinematics nobody;
  nobody.resize(0);
  Loads loads;
  const auto run = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      nobody.step = fluid.step();
      fluid.exchange(nobody, loads);
      fluid.advance();
    }
  };
  run(2);
  touch_streams(streams.data(), layout);

  const auto cells = static_cast<double>(fluid.domain().box().volume());
  nlohmann::json result = {{"ranks", ranks.size()},
                           {"domain_cells", options.domain},
                           {"precision", options.single ? "single" : "double"},
                           {"collision", name_of(collision_names, options.collision)},
                           {"kernel", choose_kernels<T>().instruction_set}};
  for (int sample = 0; sample < options.samples; ++sample) {
    const int sweeps = std::max(1, options.steps / 4);
    const double streams_s = slowest(ranks, [&] {
      for (int i = 0; i < sweeps; ++i) touch_streams(streams.data(), layout);
    });
    const double fluid_s = slowest(ranks, [&] { run(options.steps); });
    const double copy_s = slowest(ranks, [&] { copy_rate(target, source); });
    result["streams_mcells_per_s"].push_back(1e-6 * cells * sweeps / streams_s);
    result["fluid_mlups"].push_back(1e-6 * cells * options.steps / fluid_s);
    result["copy_gb_per_s"].push_back(1e-9 * 16.0 * static_cast<double>(source.size()) * ranks.size() / copy_s);
  }
  return result;
}

int run_benchmark(int argc, char** argv) {
  Options options;
  CLI::App app("Speed of the lattice Boltzmann fluid beside the speed of the memory; run under mpirun.");
  app.add_option("--domain", options.domain, "cells along x, y, z")->expected(3)->check(CLI::PositiveNumber);
  app.add_flag("--single", options.single, "single precision");
  std::map<std::string, CollisionKind> collisions;
  for (const auto& [name, kind] : collision_names) collisions[name] = kind;
  app.add_option("--collision", options.collision)->transform(CLI::CheckedTransformer(collisions));
  app.add_option("--samples", options.samples)->check(CLI::PositiveNumber);
  app.add_option("--steps", options.steps, "steps per sample")->check(CLI::PositiveNumber);
  CLI11_PARSE(app, argc, argv);
  MpiSession session;
  Communicator& ranks = session.ranks();
  const nlohmann::json result = options.single ? measure<float>(options, ranks) : measure<double>(options, ranks);
  if (ranks.rank() == 0) std::puts(result.dump().c_str());
  return session.finish(0);
}

}  // namespace
}  // namespace copepod::fluid::benchmark

int main(int argc, char** argv) { return copepod::fluid::benchmark::run_benchmark(argc, argv); }
