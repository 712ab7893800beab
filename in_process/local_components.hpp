#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>

#include <spdlog/spdlog.h>

#include "contract/errors.hpp"
#include "contract/solver_context.hpp"
#include "ranks/distributed_fluid.hpp"
#include "ranks/thread_ranks.hpp"
#include "recording/recorder.hpp"
#include "rigid_body_solver.hpp"
#include "run/components.hpp"
#include "service/rank_solver.hpp"

namespace copepod {

/// The thread of a rank other than 0.
inline void run_follower(fluid::Communicator& ranks) {
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

/// Our own fluid and body solvers in the process of the coupler: no messages, the same bits. Ranks of the fluid are
/// threads; rank 0 is the coupler's. A failure of the fluid is thrown as PeerFailed, like that of a service.
class LocalComponents final : public coupler::Components {
 public:
  explicit LocalComponents(int fluid_ranks) : fluid_ranks_(fluid_ranks) {}

  void connect() override {}
  [[nodiscard]] const Capabilities& fluid_capabilities() const override { return fluid_; }
  [[nodiscard]] const Capabilities& body_capabilities() const override { return body_; }
  /// Only a lattice can be cut into blocks: other fluids would repeat their work on every rank.
  std::unique_ptr<FluidSolver> make_fluid(const FluidSetup& setup, std::int64_t) override {
    if (!setup.trace_directory.empty())
      recording::open_timeline(fluid_context_.timeline(), setup.trace_directory, "fluid", 0);
    const int ranks = setup.kind == FluidKind::lattice_boltzmann ? fluid_ranks_ : 1;
    return std::make_unique<LocalFluid>(setup, ranks, fluid_context_);
  }
  std::unique_ptr<BodySolver> make_body(const BodySetup& setup, std::int64_t) override {
    return std::make_unique<body::RigidBodySolver>(setup, &body_context_);
  }
  void finish() override {}
  void abort(const FailureReport&) noexcept override {}

 private:
  int fluid_ranks_;
  Capabilities fluid_ = fluid::capabilities();
  Capabilities body_ = body::rigid_body_capabilities();
  SolverContext fluid_context_;
  SolverContext body_context_;
};

}  // namespace copepod
