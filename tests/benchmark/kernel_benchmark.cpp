#include <string>
#include <utility>

#include <benchmark/benchmark.h>

#include "contract/words.hpp"
#include "lattice_boltzmann/kernel/collision.hpp"
#include "lattice_boltzmann/kernel/exchange_group.hpp"
#include "lattice_boltzmann/lattice/huge_array.hpp"
#include "memory_rates.hpp"

// The kernel alone, by instruction set, precision, placement and domain, beside the memory traffic without
// arithmetic (`streams`). Items are cell updates.

namespace {

using namespace copepod;
using namespace copepod::fluid;

constexpr Box paper{{0, 0, 0}, {100, 100, 200}};
constexpr Box quarter{{0, 0, 0}, {50, 50, 200}};

template <class T>
CollisionConstants<T> constants(CollisionKind collision) {
  return collision_constants<T>(collision, 2.0 / 3.0, Eigen::Vector3d::Zero());
}

template <class T>
void stream_collide(::benchmark::State& state, StreamCollide<T> update, Placement placement, const Box& box,
                    CollisionKind collision) {
  if (update == nullptr) return state.SkipWithError("this machine cannot run it");
  const PopulationLayout layout(box, sizeof(T));
  HugeArray<T> populations(static_cast<std::size_t>(layout.values()));
  for (auto _ : state) {
    update(populations.data(), layout, placement, box, constants<T>(collision), false, nullptr);
    ::benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * box.volume());
}

template <class T>
void streams(::benchmark::State& state, const Box& box) {
  const PopulationLayout layout(box, sizeof(T));
  HugeArray<T> populations(static_cast<std::size_t>(layout.values()));
  for (auto _ : state) {
    fluid::benchmark::touch_streams(populations.data(), layout);
    ::benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * box.volume());
}

template <class T>
void add(const std::string& precision) {
  for (const auto& [domain, box] : {std::pair{"100x100x200", paper}, std::pair{"50x50x200", quarter}}) {
    const std::string suffix = "/" + precision + "/" + domain;
    for (const auto& [name, placement] :
         {std::pair{"home", Placement::home}, std::pair{"streamed", Placement::streamed}}) {
      for (const auto& [set, update] : {std::pair{"avx512/", avx512_kernels<T>().stream_collide},
                                        {"avx2/", avx2_kernels<T>().stream_collide},
                                        {"baseline/", baseline_kernels<T>().stream_collide}})
        for (const auto collision : {CollisionKind::trt, CollisionKind::central_moments})
          ::benchmark::RegisterBenchmark(
              (set + std::string(name) + suffix + "/" + name_of(collision_names, collision)).c_str(), stream_collide<T>,
              update, placement, box, collision);
    }
    ::benchmark::RegisterBenchmark(("streams" + suffix).c_str(), streams<T>, box);
  }
}

}  // namespace

int main(int argc, char** argv) {
  add<double>("double");
  add<float>("single");
  ::benchmark::Initialize(&argc, argv);
  ::benchmark::RunSpecifiedBenchmarks();
}
