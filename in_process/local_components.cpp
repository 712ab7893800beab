#include "local_components.hpp"

#include <atomic>
#include <optional>

#include <spdlog/spdlog.h>

#include "contract/errors.hpp"
#include "ranks/distributed_fluid.hpp"
#include "ranks/rank_failure.hpp"
#include "ranks/thread_ranks.hpp"
#include "recording/recorder.hpp"
#include "rigid_body_solver.hpp"
#include "service/rank_solver.hpp"

namespace copepod {

namespace {

/// The thread of a rank other than 0.
void run_follower(fluid::Communicator& ranks) {
  std::atomic<std::int64_t> step{-1};
  try {
    fluid::follow(ranks, fluid::make_rank_solver, step);
  } catch (const PeerFailed&) {
    // That rank reports why.
  } catch (const Error& error) {
    spdlog::error("rank {} of the fluid failed at step {}: {}", error.rank(), error.step(), error.what());
  }
}

/// @param step  used where the error has none
/// @throws PeerFailed in place of any other exception
template <class Action>
auto as_fluid(std::int64_t step, const Action& action) {
  try {
    return action();
  } catch (const PeerFailed&) {
    throw;
  } catch (const std::exception& error) {
    throw PeerFailed(fluid::failure_of_rank(error, 0, step));
  }
}

/// The fluid with all its ranks. An exception is thrown as PeerFailed, but for a checkpoint that cannot be written.
class LocalFluid final : public FluidSolver {
 public:
  /// @param ranks    1: no threads
  /// @param context  of rank 0; outlives this object
  LocalFluid(const FluidSetup& setup, int ranks, SolverContext& context) : ranks_(ranks, context, run_follower) {
    as_fluid(step_, [&] {
      if (ranks == 1)
        solver_ = fluid::make_rank_solver(setup, ranks_.leader());
      else
        solver_ = std::make_unique<fluid::DistributedFluid>(setup, ranks_.leader(), fluid::make_rank_solver);
    });
  }
  LocalFluid(const LocalFluid&) = delete;
  LocalFluid& operator=(const LocalFluid&) = delete;
  ~LocalFluid() override {
    solver_.reset();
    fluid::dismiss_followers(ranks_.leader());
  }

  void exchange(const Kinematics& kinematics, Loads& loads) override {
    step_ = kinematics.step;
    as_fluid(step_, [&] { solver_->exchange(kinematics, loads); });
  }
  void advance() override {
    as_fluid(step_, [&] { solver_->advance(); });
  }
  void save(const std::string& path) override {
    std::optional<StorageError> problem;
    as_fluid(step_, [&] {
      try {
        solver_->save(path);
      } catch (const StorageError& error) {
        problem = error;
      }
    });
    if (problem) throw StorageError(*problem);
  }
  void restore(const std::string& path) override {
    as_fluid(step_, [&] { solver_->restore(path); });
  }
  SolverSummary summarise() override {
    return as_fluid(step_, [&] { return solver_->summarise(); });
  }

 private:
  fluid::ThreadRanks ranks_;
  std::unique_ptr<FluidSolver> solver_;
  std::int64_t step_ = -1;
};

}  // namespace

LocalComponents::LocalComponents(int fluid_ranks)
    : fluid_ranks_(fluid_ranks), fluid_(fluid::capabilities()), body_(body::rigid_body_capabilities()) {}

/// Only a lattice can be cut into blocks: other fluids would repeat their work on every rank.
std::unique_ptr<FluidSolver> LocalComponents::make_fluid(const FluidSetup& setup, std::int64_t) {
  if (!setup.trace_directory.empty())
    recording::open_timeline(fluid_context_.timeline(), setup.trace_directory, "fluid", 0);
  const int ranks = setup.kind == FluidKind::lattice_boltzmann ? fluid_ranks_ : 1;
  return std::make_unique<LocalFluid>(setup, ranks, fluid_context_);
}

std::unique_ptr<BodySolver> LocalComponents::make_body(const BodySetup& setup, std::int64_t) {
  return std::make_unique<body::RigidBodySolver>(setup, &body_context_);
}

}  // namespace copepod
