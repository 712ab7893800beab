#include <array>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "contract/errors.hpp"
#include "ranks/distributed_fluid.hpp"
#include "test_on_ranks.hpp"

namespace copepod::fluid {
namespace {

enum class Where { construct, exchange, advance, save, nowhere };

/// Where and on which rank the solver fails; always at step 2.
struct Fault {
  Where where;
  int rank;
};

/// Exchanges something with all other ranks in every call, like a real solver, and fails on request.
class FaultySolver final : public FluidSolver {
 public:
  FaultySolver(Communicator& communicator, Fault fault) : communicator_(communicator), fault_(fault) {
    fail_if(Where::construct);
    talk();
  }
  void exchange(const Kinematics& kinematics, Loads&) override {
    step_ = kinematics.step;
    if (step_ == 2) fail_if(Where::exchange);
    talk();
  }
  void advance() override {
    if (step_ == 2) fail_if(Where::advance);
    exchange_with_neighbours();
  }
  void save(const std::string&) override {
    fail_if(Where::save);
    talk();
  }
  void restore(const std::string&) override {}
  SolverSummary summarise() override { return {}; }

 private:
  void fail_if(Where where) const {
    if (fault_.where == where && fault_.rank == communicator_.rank())
      throw SolverError("cell (1, 2, 3) diverged (on purpose). Nothing to do.", 0, step_);
  }
  void talk() {
    std::array<std::int64_t, 1> value = {1};
    communicator_.sum_to_leader(value);
  }
  void exchange_with_neighbours() {
    const int next = (communicator_.rank() + 1) % communicator_.size();
    const int previous = (communicator_.rank() + communicator_.size() - 1) % communicator_.size();
    const std::vector<std::byte> sent(100000);
    std::vector<std::byte> above(sent.size());
    std::vector<std::byte> below(sent.size());
    const std::array<Communicator::Message, 2> messages = {{{next, sent, above}, {previous, sent, below}}};
    communicator_.start_exchange(messages)();
  }

  Communicator& communicator_;
  Fault fault_;
  std::int64_t step_ = -1;
};

void run_five_steps(Communicator& ranks, const RankSolverFactory& make_solver) {
  DistributedFluid fluid({}, ranks, make_solver);
  Kinematics kinematics;
  Loads loads;
  for (kinematics.step = 0; kinematics.step < 5; ++kinematics.step) {
    fluid.exchange(kinematics, loads);
    fluid.advance();
  }
  fluid.save("checkpoint");
  kinematics.step = 5;
  fluid.exchange(kinematics, loads);  // at the latest here a failure during save reaches rank 0
  fluid.advance();
}

/// Collective as long as the ranks are not broken.
bool is_broken(Communicator& ranks) {
  try {
    ranks.max_to_all({});
    return false;
  } catch (const PeerFailed&) {
    return true;
  }
}

/// @return what this rank learned
FailureReport learn_of(Fault fault, Communicator& ranks) {
  const RankSolverFactory make_solver = [=](const FluidSetup&, Communicator& communicator) {
    return std::make_unique<FaultySolver>(communicator, fault);
  };
  FailureReport learned;
  std::atomic<std::int64_t> step{-1};
  learned.reason = "nothing happened";
  try {
    if (ranks.rank() == 0) {
      run_five_steps(ranks, make_solver);
      dismiss_followers(ranks);
    } else {
      follow(ranks, make_solver, step);
    }
  } catch (const PeerFailed& failure) {
    EXPECT_TRUE(ranks.rank() == 0 || ranks.rank() != fault.rank)
        << "a rank's own failure came back to it as that of a peer; only rank 0 throws what all ranks learn";
    learned = failure.report();
  } catch (const Error& error) {
    EXPECT_EQ(ranks.rank(), fault.rank) << error.what();
    learned = {error.code(), "fluid", "here", error.rank(), error.step(), error.what()};
  }
  EXPECT_EQ(is_broken(ranks), fault.where != Where::nowhere);
  return learned;
}

class FailureOn : public testing::TestWithParam<std::tuple<Where, int>> {};

TEST_P_ON_RANKS(FailureOn, ReachesEveryRank) {
  const auto [where, rank] = parameter;
  if (rank >= ranks.size()) GTEST_SKIP() << "there is no such rank";
  const FailureReport learned = learn_of({where, rank}, ranks);
  EXPECT_EQ(learned.rank, rank);
  EXPECT_EQ(learned.code, ExitCode::solver_failed);
  EXPECT_EQ(learned.reason, "cell (1, 2, 3) diverged (on purpose). Nothing to do.");
  if (where == Where::exchange || where == Where::advance) {
    EXPECT_EQ(learned.step, 2);
  }
}

INSTANTIATE_TEST_SUITE_P(EveryCallAndRank, FailureOn,
                         testing::Combine(testing::Values(Where::construct, Where::exchange, Where::advance,
                                                          Where::save),
                                          testing::Values(0, 1, 2)));

TEST_ON_RANKS(Failure, IsNotReportedWhenThereIsNone) {
  EXPECT_EQ(learn_of({Where::nowhere, 0}, ranks).reason, "nothing happened");
}

TEST_ON_RANKS(Failure, EndsTheOtherRanksWhenRankZeroLeavesBeforeTheBulkUpdate) {
  const RankSolverFactory make_solver = [](const FluidSetup&, Communicator& communicator) {
    return std::make_unique<FaultySolver>(communicator, Fault{Where::nowhere, 0});
  };
  if (ranks.size() == 1) GTEST_SKIP() << "needs another rank";
  if (ranks.rank() != 0) {
    std::atomic<std::int64_t> step{-1};
    EXPECT_THROW(follow(ranks, make_solver, step), PeerFailed);
    return;
  }
  DistributedFluid fluid({}, ranks, make_solver);
  Loads loads;
  fluid.exchange(Kinematics{}, loads);
}

TEST_ON_RANKS(Failure, BreaksTheCommunicatorForGood) {
  if (ranks.size() == 1) GTEST_SKIP() << "needs another rank";
  const FailureReport report{ExitCode::solver_failed, "fluid", "here", 1, 9, "first"};
  std::array<std::int64_t, 1> value = {1};
  if (ranks.rank() == 1) {
    ranks.report_failure(report);
    ranks.report_failure({ExitCode::solver_failed, "fluid", "here", 1, 10, "second"});
  } else {
    EXPECT_THROW(ranks.sum_to_all(value), PeerFailed);
  }
  try {
    ranks.broadcast(std::as_writable_bytes(std::span(value)));
    FAIL() << "a broken communicator was used";
  } catch (const PeerFailed& failure) {
    EXPECT_EQ(failure.report().reason, "first");
    EXPECT_EQ(failure.report().rank, 1);
  }
}

}  // namespace
}  // namespace copepod::fluid
