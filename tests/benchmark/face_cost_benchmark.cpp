#include <cstring>
#include <vector>

#include <benchmark/benchmark.h>

#include "lattice_boltzmann/lattice/d3q19.hpp"
#include "lattice_boltzmann/lattice/population_layout.hpp"

// What a face cell of a block costs, by the direction of its normal, beside the memory traffic of a cell
// update: the ratios behind step_cost in ranks/block_partition.cpp. Time per item is time per cell.

namespace {

using namespace copepod::fluid;

constexpr std::int64_t cells = 100;  // along each axis

std::vector<int> directions_through_face(int axis) {
  std::vector<int> directions;
  for (int alpha = 0; alpha < d3q19::directions; ++alpha)
    if (d3q19::e[alpha][axis] == 1) directions.push_back(alpha);
  return directions;
}

/// Packs the five populations that leave through a face, copies them once as a message would, and
/// unpacks them.
void face(benchmark::State& state) {
  const int axis = static_cast<int>(state.range(0));
  const PopulationLayout layout({{0, 0, 0}, {cells, cells, cells}}, sizeof(double));
  std::vector<double> populations(static_cast<std::size_t>(layout.values()));
  const std::vector<int> directions = directions_through_face(axis);
  std::vector<double> packed(directions.size() * cells * cells);
  std::vector<double> received(packed.size());
  const auto for_each_run = [&](std::int64_t plane, auto&& visit) {
    for (const int alpha : directions)
      for (std::int64_t a = 0; a < cells; ++a) {
        if (axis == 2) {
          for (std::int64_t b = 0; b < cells; ++b) visit(layout.slot(alpha) + layout.cell(a, b, plane), 1);
        } else {
          visit(layout.slot(alpha) + (axis == 0 ? layout.cell(plane, a, 0) : layout.cell(a, plane, 0)), cells);
        }
      }
  };
  std::vector<double> rest(50'000'000);  // between two exchanges the bulk update drives the faces out of the caches
  for (auto _ : state) {
    state.PauseTiming();
    for (std::size_t i = 0; i < rest.size(); i += 8) rest[i] += 1.0;
    state.ResumeTiming();
    double* out = packed.data();
    for_each_run(cells - 1, [&](std::int64_t from, std::int64_t count) {
      std::memcpy(out, populations.data() + from, static_cast<std::size_t>(count) * sizeof(double));
      out += count;
    });
    std::memcpy(received.data(), packed.data(), packed.size() * sizeof(double));
    const double* in = received.data();
    for_each_run(0, [&](std::int64_t to, std::int64_t count) {
      std::memcpy(populations.data() + to, in, static_cast<std::size_t>(count) * sizeof(double));
      in += count;
    });
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * cells * cells);
}
BENCHMARK(face)->Arg(0)->Arg(1)->Arg(2)->ArgName("normal");

/// Reads and writes the 19 populations of every cell once.
void cell(benchmark::State& state) {
  const PopulationLayout layout({{0, 0, 0}, {cells, cells, cells}}, sizeof(double));
  std::vector<double> populations(static_cast<std::size_t>(layout.values()));
  for (auto _ : state) {
    for (std::int64_t x = 0; x < cells; ++x)
      for (std::int64_t y = 0; y < cells; ++y)
        for (int alpha = 0; alpha < d3q19::directions; ++alpha) {
          double* row = populations.data() + layout.slot(alpha) + layout.cell(x, y, 0);
          for (std::int64_t z = 0; z < cells; ++z) row[z] = row[z] * 0.999 + 1e-9;
        }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * cells * cells * cells);
}
BENCHMARK(cell);

}  // namespace

BENCHMARK_MAIN();
