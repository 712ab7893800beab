#include <chrono>
#include <cstdlib>
#include <iostream>
#include <thread>

#include "contract/errors.hpp"
#include "ranks/distributed_fluid.hpp"
#include "ranks/mpi_communicator.hpp"

namespace {

using namespace copepod;
using namespace copepod::fluid;

/// Fails on one rank at step 3.
class FailingSolver final : public FluidSolver {
 public:
  FailingSolver(Communicator& communicator, int failing_rank)
      : communicator_(communicator), failing_rank_(failing_rank) {}

  void exchange(const Kinematics& kinematics, Loads&) override {
    if (kinematics.step == 3 && communicator_.rank() == failing_rank_)
      throw StorageError("disk full (on purpose). Nothing to do.");
    std::int64_t one = 1;
    communicator_.sum_to_leader(std::span(&one, 1));
  }
  void advance() override {}
  void save(const std::string&) override {}
  void restore(const std::string&) override {}
  SolverSummary summarise() override { return {}; }

 private:
  Communicator& communicator_;
  int failing_rank_;
};

int run(MpiSession& session, int failing_rank) {
  const RankSolverFactory make_solver = [=](const FluidSetup&, Communicator& ranks) {
    return std::make_unique<FailingSolver>(ranks, failing_rank);
  };
  try {
    if (session.ranks().rank() != 0) {
      std::atomic<std::int64_t> step{-1};
      follow(session.ranks(), make_solver, step);
      return 0;
    }
    DistributedFluid fluid({}, session.ranks(), make_solver);
    Kinematics kinematics;
    Loads loads;
    for (kinematics.step = 0; kinematics.step < 10; ++kinematics.step) {
      fluid.exchange(kinematics, loads);
      fluid.advance();
    }
    dismiss_followers(session.ranks());
    return 0;
  } catch (const Error& error) {
    if (session.ranks().rank() == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));  // telling the coupler takes a while
      std::cout << "rank " << error.rank() << " step " << error.step() << ": " << error.what() << std::endl;
    }
    return static_cast<int>(error.code());
  }
}

}  // namespace

/// failing_session RANK: a fluid service in which RANK fails at step 3.
int main(int argc, char** argv) {
  MpiSession session;
  return session.finish(run(session, argc > 1 ? std::atoi(argv[1]) : 0));
}
