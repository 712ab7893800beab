#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "lattice_boltzmann/lattice_boltzmann.hpp"

// What rank 0 does for 10⁵ spheres of radius 2 on 10³ ranks of 10⁶ cells (docs/results/scaling.md): it sends their
// states and adds up their loads, items are records; and a whole exchange, with the report in SI units and the bodies
// near rank 0, items are bodies.

namespace {

using namespace copepod;
using namespace copepod::fluid;

constexpr int size = 1000;
constexpr int bodies = 100000;

/// Rank 0 without the others: keeps what it is to send, and receives loads of as many bodies from each.
class LonelyLeader final : public SelfCommunicator {
 public:
  using SelfCommunicator::SelfCommunicator;
  [[nodiscard]] int size() const override { return ::size; }
  [[nodiscard]] std::function<void()> start_send(int, std::span<const std::byte> data) override {
    sent_.push_back(data);
    return [] {};
  }
  void receive(int, std::vector<std::byte>& data) override { data = loads_[next_++ % loads_.size()]; }

  /// From each rank that has been sent records: loads of the same bodies.
  std::int64_t answer_with_loads() {
    std::int64_t records = 0;
    loads_.clear();
    for (const std::span<const std::byte> message : sent_) {
      std::vector<std::byte>& loads = loads_.emplace_back(sizeof(MomentumSums));
      for (std::size_t at = 0; at < message.size();) {
        std::int64_t count = 0;
        std::memcpy(&count, message.data() + at, sizeof(count));
        at += sizeof(count);
        for (std::int64_t i = 0; i < count; ++i, at += sizeof(std::int32_t) + 9 * sizeof(double)) {
          std::uint32_t body = 0;
          std::memcpy(&body, message.data() + at, sizeof(body));
          std::array<std::byte, sizeof(body) + 6 * sizeof(std::int64_t)> entry;
          entry.fill(std::byte{1});  // any load but 0
          body *= 2;
          std::memcpy(entry.data(), &body, sizeof(body));
          loads.insert(loads.end(), entry.begin(), entry.end());
        }
        records += count;
      }
    }
    return records;
  }
  void forget() { sent_.clear(); }

 private:
  std::vector<std::span<const std::byte>> sent_;
  std::vector<std::vector<std::byte>> loads_{std::vector<std::byte>(sizeof(MomentumSums))};
  std::size_t next_ = 0;
};

FluidSetup setup() {
  FluidSetup result;
  result.step_s = result.cell_size_m = result.density_kg_per_m3 = 1.0;
  result.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  result.domain_cells = {1000, 1000, 1000};
  for (Boundary& face : result.boundaries) face.kind = BoundaryKind::periodic;
  result.bodies.assign(bodies, {ShapeKind::sphere, 2.0, 0.0});
  return result;
}

/// @param ordered  bodies that are neighbours in space are neighbours in the setup
Kinematics spread(bool ordered) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> anywhere(0.0, 1000.0);
  const BlockPartition partition({1000, 1000, 1000}, size);
  std::vector<std::pair<int, Eigen::Vector3d>> places(bodies);
  for (auto& [rank, place] : places) {
    place = {anywhere(generator), anywhere(generator), anywhere(generator)};
    rank = partition.owner({static_cast<int>(place[0]), static_cast<int>(place[1]), static_cast<int>(place[2])});
  }
  if (ordered) std::ranges::stable_sort(places, {}, [](const auto& place) { return place.first; });
  Kinematics kinematics;
  kinematics.resize(bodies);
  for (Eigen::Index b = 0; b < bodies; ++b) kinematics.position_m.col(b) = places[static_cast<std::size_t>(b)].second;
  kinematics.velocity_m_per_s.setZero();
  kinematics.angular_velocity_rad_per_s.setZero();
  return kinematics;
}

void drift(Kinematics& kinematics) { kinematics.position_m.row(0).array() += 0.01; }

class Rank0 {
 public:
  explicit Rank0(bool ordered) : kinematics_(spread(ordered)) {
    scatter();
    records_ = leader_.answer_with_loads();
    loads_.resize(nearby_.bodies().size());
  }

  void scatter() {
    leader_.forget();
    drift(kinematics_);
    nearby_.scatter(kinematics_, {});
  }
  void gather() {
    MomentumSums gained{};
    nearby_.gather(loads_, gained);
    benchmark::DoNotOptimize(nearby_.total(0, 0));
  }
  [[nodiscard]] std::int64_t records() const { return records_; }

 private:
  SolverContext context_;
  LonelyLeader leader_{context_};
  LatticeUnits units_{setup()};
  Domain domain_{setup(), units_};
  BlockPartition partition_{domain_.cells(), size};
  NearbyBodies nearby_{setup(), units_, domain_, partition_, false, leader_};
  Kinematics kinematics_;
  std::vector<LoadSums> loads_;
  std::int64_t records_ = 0;
};

void scatter(benchmark::State& state) {
  Rank0 rank(state.range(0) == 1);
  for (auto _ : state) rank.scatter();
  state.SetItemsProcessed(state.iterations() * rank.records());
}
BENCHMARK(scatter)->Arg(0)->Arg(1)->ArgName("ordered")->Unit(benchmark::kMillisecond);

void gather(benchmark::State& state) {
  Rank0 rank(state.range(0) == 1);
  for (auto _ : state) rank.gather();
  state.SetItemsProcessed(state.iterations() * rank.records());
}
BENCHMARK(gather)->Arg(0)->Arg(1)->ArgName("ordered")->Unit(benchmark::kMillisecond);

void exchange(benchmark::State& state) {
  SolverContext context;
  LonelyLeader leader(context);
  LatticeBoltzmann<double> fluid(setup(), leader);
  Kinematics kinematics = spread(state.range(0) == 1);
  Loads loads;
  const auto step = [&] {
    leader.forget();
    drift(kinematics);
    fluid.exchange(kinematics, loads);
  };
  step();
  leader.answer_with_loads();
  for (auto _ : state) step();
  state.SetItemsProcessed(state.iterations() * bodies);
}
BENCHMARK(exchange)->Arg(0)->Arg(1)->ArgName("ordered")->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
