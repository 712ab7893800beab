#include "ranks/distributed_fluid.hpp"

#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "test_on_ranks.hpp"

namespace copepod::fluid {
namespace {

using Calls = std::vector<std::string>;

/// Writes down its calls; its loads are the sum over ranks of (rank + 1) · position.
class RecordingSolver final : public FluidSolver {
 public:
  RecordingSolver(const FluidSetup& setup, Communicator& communicator, Calls& calls)
      : communicator_(communicator), calls_(calls) {
    calls_.push_back("construct " + std::to_string(setup.domain_cells[2]));
  }

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    calls_.push_back("exchange " + std::to_string(kinematics.step));
    loads.resize(kinematics.bodies());
    loads.step = kinematics.step;
    for (Eigen::Index body = 0; body < kinematics.bodies(); ++body) {
      std::array<std::int64_t, 1> load = {(communicator_.rank() + 1) *
                                          static_cast<std::int64_t>(kinematics.position_m(0, body))};
      communicator_.sum_to_leader(load);
      loads.force_N(0, body) = static_cast<double>(load[0]);
    }
  }
  void advance() override { calls_.emplace_back("advance"); }
  void save(const std::string& path) override {
    calls_.push_back("save " + path);
    if (path == "full disk") throw StorageError("no room (on purpose). Nothing to do.");
  }
  void restore(const std::string& path) override { calls_.push_back("restore " + path); }
  SolverSummary summarise() override {
    calls_.emplace_back("summarise");
    std::array<std::int64_t, 1> digest = {communicator_.rank() + 10};
    communicator_.sum_to_leader(digest);
    SolverSummary summary;
    summary.digest = static_cast<std::uint64_t>(digest[0]);
    return summary;
  }

 private:
  Communicator& communicator_;
  Calls& calls_;
};

void run_two_steps(Communicator& ranks, const RankSolverFactory& make_solver, Eigen::Index bodies) {
  FluidSetup setup;
  setup.domain_cells = {1, 2, 77};
  DistributedFluid fluid(setup, ranks, make_solver);
  fluid.restore("here");
  Kinematics kinematics;
  kinematics.resize(bodies);
  kinematics.position_m.setConstant(7.0);
  Loads loads;
  for (kinematics.step = 5; kinematics.step < 7; ++kinematics.step) {
    fluid.exchange(kinematics, loads);
    fluid.advance();
    const int n = ranks.size();
    ASSERT_EQ(loads.bodies(), bodies);
    EXPECT_EQ(loads.step, kinematics.step);
    EXPECT_EQ(loads.force_N(0, bodies - 1), 7.0 * n * (n + 1) / 2);
  }
  EXPECT_THROW(fluid.save("full disk"), StorageError);
  fluid.save("there");
  EXPECT_EQ(fluid.summarise().digest,
            static_cast<std::uint64_t>(10 * ranks.size() + ranks.size() * (ranks.size() - 1) / 2));
}

class DistributedFluidWith : public testing::TestWithParam<Eigen::Index> {};

TEST_P_ON_RANKS(DistributedFluidWith, MakesTheSameCallsOnEveryRank) {
  Calls calls;
  const RankSolverFactory make_solver = [&](const FluidSetup& setup, Communicator& communicator) {
    return std::make_unique<RecordingSolver>(setup, communicator, calls);
  };
  std::atomic<std::int64_t> step{-1};
  if (ranks.rank() == 0) {
    run_two_steps(ranks, make_solver, parameter);
    dismiss_followers(ranks);
  } else {
    follow(ranks, make_solver, step);
    EXPECT_EQ(step, 6);
  }
  EXPECT_EQ(calls, (Calls{"construct 77", "restore here", "exchange 5", "advance", "exchange 6", "advance",
                          "save full disk", "save there", "summarise"}));
}

INSTANTIATE_TEST_SUITE_P(OneAndTwoBroadcasts, DistributedFluidWith, testing::Values(3, 50));

TEST_ON_RANKS(DistributedFluid, LetsTheOtherRanksGoWhenThereWasNeverASolver) {
  const RankSolverFactory make_solver = [](const FluidSetup&, Communicator&) -> std::unique_ptr<FluidSolver> {
    ADD_FAILURE() << "no solver should be made";
    return nullptr;
  };
  std::atomic<std::int64_t> step{-1};
  if (ranks.rank() == 0) {
    dismiss_followers(ranks);
  } else {
    follow(ranks, make_solver, step);
  }
}

}  // namespace
}  // namespace copepod::fluid
