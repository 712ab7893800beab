#include <array>
#include <atomic>
#include <cstdio>
#include <map>
#include <vector>

#include <gtest/gtest.h>

#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "ranks/distributed_fluid.hpp"
#include "ranks/thread_ranks.hpp"

namespace copepod::fluid {
namespace {

/// What a rank sends and receives for its bodies: orders, records and loads of bodies.
struct Traffic {
  std::int64_t messages_sent = 0;
  std::int64_t bytes_sent = 0;
  std::int64_t messages_received = 0;
  std::int64_t bytes_received = 0;

  bool operator==(const Traffic&) const = default;
};

Traffic operator-(const Traffic& a, const Traffic& b) {
  return {a.messages_sent - b.messages_sent, a.bytes_sent - b.bytes_sent, a.messages_received - b.messages_received,
          a.bytes_received - b.bytes_received};
}

/// A communicator that counts; exchanges with neighbours are those of the fluid, which has as many without bodies.
/// Sums and broadcasts count as one message each, of which MPI makes more on the way.
class CountingCommunicator final : public Communicator {
 public:
  explicit CountingCommunicator(Communicator& counted) : Communicator(counted.context()), counted_(counted) {}
  [[nodiscard]] const Traffic& traffic() const { return traffic_; }

  [[nodiscard]] int rank() const override { return counted_.rank(); }
  [[nodiscard]] int size() const override { return counted_.size(); }
  void broadcast(std::span<std::byte> data) override {
    if (rank() == 0)
      count_sent(data.size());
    else
      count_received(data.size());
    counted_.broadcast(data);
  }
  void reduce_to_leader(std::span<std::int64_t> values, Reduction reduction) override {
    if (rank() == 0)
      count_received(values.size_bytes());
    else
      count_sent(values.size_bytes());
    counted_.reduce_to_leader(values, reduction);
  }
  [[nodiscard]] std::function<void()> start_exchange(std::span<const Message> messages) override {
    return counted_.start_exchange(messages);
  }
  [[nodiscard]] std::function<void()> start_send(int peer, std::span<const std::byte> data) override {
    count_sent(data.size());
    return counted_.start_send(peer, data);
  }
  void receive(int peer, std::vector<std::byte>& data) override {
    counted_.receive(peer, data);
    count_received(data.size());
  }
  void report_failure(const FailureReport& report) override { counted_.report_failure(report); }

 private:
  void count_sent(std::size_t bytes) {
    if (size() == 1) return;
    ++traffic_.messages_sent;
    traffic_.bytes_sent += static_cast<std::int64_t>(bytes);
  }
  void count_received(std::size_t bytes) {
    if (size() == 1) return;
    ++traffic_.messages_received;
    traffic_.bytes_received += static_cast<std::int64_t>(bytes);
  }

  Communicator& counted_;
  Traffic traffic_;
};

constexpr std::int64_t width = 16;  ///< of a rank's cube
constexpr int bodies_per_rank = 8;

/// A chain of cubes with the same spheres in each, two cells or more from where blocks end: that of rank 0 is shorter
/// than the others.
FluidSetup chain_of_cubes(int ranks, MovingBoundary moving_boundary) {
  FluidSetup setup;
  setup.step_s = setup.cell_size_m = setup.density_kg_per_m3 = 1.0;
  setup.kinematic_viscosity_m2_per_s = 1.0 / 18.0;
  setup.domain_cells = {width * ranks, width, width};
  for (Boundary& face : setup.boundaries) face.kind = BoundaryKind::periodic;
  setup.moving_boundary = moving_boundary;
  setup.bodies.assign(static_cast<std::size_t>(bodies_per_rank * ranks), {ShapeKind::sphere, 2.0, 0.0});
  return setup;
}

Kinematics drifting(std::int64_t step, int ranks) {
  Kinematics kinematics;
  kinematics.step = step;
  kinematics.resize(bodies_per_rank * ranks);
  kinematics.velocity_m_per_s.setZero();
  kinematics.velocity_m_per_s.row(0).setConstant(0.01);
  kinematics.angular_velocity_rad_per_s.setZero();
  kinematics.orientation_wxyz.setZero();
  kinematics.orientation_wxyz.row(0).setOnes();
  for (int b = 0; b < kinematics.bodies(); ++b) {
    const int in_cube = b % bodies_per_rank;
    for (int axis = 0; axis < 3; ++axis) kinematics.position_m(axis, b) = ((in_cube >> axis) & 1) == 0 ? 4.2 : 10.2;
    kinematics.position_m(0, b) +=
        static_cast<double>(width) * static_cast<double>(b / bodies_per_rank) + 0.01 * static_cast<double>(step);
  }
  return kinematics;
}

/// Of each rank, in a run of so many steps.
std::vector<Traffic> traffic_of_run(int size, MovingBoundary moving_boundary, std::int64_t steps) {
  std::vector<Traffic> result(static_cast<std::size_t>(size));
  SolverContext context;
  ThreadRanks ranks(size, context, [&](Communicator& own) {
    CountingCommunicator counting(own);
    std::atomic<std::int64_t> step{-1};
    follow(counting, make_lattice_boltzmann, step);
    result[static_cast<std::size_t>(own.rank())] = counting.traffic();
  });
  CountingCommunicator counting(ranks.leader());
  {
    DistributedFluid fluid(chain_of_cubes(size, moving_boundary), counting, make_lattice_boltzmann);
    Loads loads;
    for (std::int64_t step = 0; step < steps; ++step) {
      fluid.exchange(drifting(step, size), loads);
      fluid.advance();
    }
  }
  dismiss_followers(counting);
  result[0] = counting.traffic();
  return result;
}

class WeakScalingOfBodies : public testing::TestWithParam<MovingBoundary> {};

TEST_P(WeakScalingOfBodies, HasARankOtherThanTheFirstSendAndReceiveTheSameForAnyNumberOfRanks) {
  constexpr std::int64_t steps = 4;
  std::map<int, std::vector<Traffic>> per_steps;
  for (const int size : {1, 2, 4, 8}) {
    const auto start = traffic_of_run(size, GetParam(), 1);
    auto all = traffic_of_run(size, GetParam(), 1 + steps);
    for (std::size_t rank = 0; rank < all.size(); ++rank) all[rank] = all[rank] - start[rank];
    for (const std::size_t rank : {std::size_t{0}, std::size_t{1}}) {
      if (rank >= all.size()) continue;
      const Traffic& t = all[rank];
      std::printf("%d ranks, %s, a step: %g messages of %g bytes sent, %g of %g received\n", size,
                  rank == 0 ? "rank 0" : "any other", static_cast<double>(t.messages_sent) / steps,
                  static_cast<double>(t.bytes_sent) / steps, static_cast<double>(t.messages_received) / steps,
                  static_cast<double>(t.bytes_received) / steps);
    }
    per_steps[size] = all;
  }
  EXPECT_EQ(per_steps[1][0], Traffic{});
  const Traffic& expected = per_steps[2][1];
  EXPECT_EQ(expected.messages_sent, steps);          // loads
  EXPECT_EQ(expected.messages_received, 2 * steps);  // the order, and records
  EXPECT_GT(expected.bytes_sent, bodies_per_rank * steps * 48);
  EXPECT_GT(expected.bytes_received, bodies_per_rank * steps * 72);
  for (const int size : {2, 4, 8})
    for (std::size_t rank = 1; rank < static_cast<std::size_t>(size); ++rank)
      EXPECT_EQ(per_steps[size][rank], expected) << "rank " << rank << " of " << size;
  // The first rank has to do with all bodies, and with nothing else.
  const std::int64_t to_one_rank = expected.bytes_received - steps * 24;
  for (const int size : {2, 4, 8}) {
    EXPECT_EQ(per_steps[size][0].bytes_received, (size - 1) * expected.bytes_sent);
    EXPECT_EQ(per_steps[size][0].bytes_sent, (size - 1) * to_one_rank + steps * 24);
  }
}

INSTANTIATE_TEST_SUITE_P(Formulas, WeakScalingOfBodies,
                         testing::Values(MovingBoundary::bounce_back, MovingBoundary::parabolic));

}  // namespace
}  // namespace copepod::fluid
