#include "local_components.hpp"

#include <atomic>

#include <spdlog/spdlog.h>

#include "contract/errors.hpp"
#include "ranks/distributed_fluid.hpp"
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

/// Threads that follow rank 0 until this object ends.
struct Followers {
  Followers(int count, SolverContext& context) : ranks(count, context, run_follower) {}
  Followers(const Followers&) = delete;
  Followers& operator=(const Followers&) = delete;
  ~Followers() { fluid::dismiss_followers(ranks.leader()); }

  fluid::ThreadRanks ranks;
};

/// The fluid with all its ranks, which outlive the solver.
class LocalFluid final : private Followers, public fluid::DistributedFluid {
 public:
  /// @param count    of ranks; 1: no threads
  /// @param context  of rank 0; outlives this object
  LocalFluid(const FluidSetup& setup, int count, SolverContext& context)
      : Followers(count, context), DistributedFluid(setup, ranks.leader(), fluid::make_rank_solver) {}
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
