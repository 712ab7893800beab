#pragma once

#include <functional>
#include <memory>
#include <string>

#include "contract/fluid_solver.hpp"
#include "ranks/command.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// Makes one rank's part of a solver; every method of it is called on all ranks with the same arguments.
using RankSolverFactory = std::function<std::unique_ptr<FluidSolver>(const FluidSetup&, Communicator&)>;

/// A solver that is spread over ranks, as seen on rank 0: passes every call on to the other ranks
/// (follower.hpp) and makes the same call on its own part. Loads and summaries are those of its own part.
///
/// An exception on any rank ends all of them: on another rank it arrives here as PeerFailed, naming the rank;
/// on this one it is reported to the others and thrown on. `advance` costs no message, since the others
/// advance by themselves.
class DistributedFluid final : public FluidSolver {
 public:
  DistributedFluid(const FluidSetup& setup, Communicator& communicator, const RankSolverFactory& make_solver);
  /// Between exchange and advance the other ranks wait for this one's share of the bulk update: ends them by
  /// a failure.
  ~DistributedFluid() override;

  void exchange(const Kinematics& kinematics, Loads& loads) override;
  void advance() override;
  void save(const std::string& path) override;
  void restore(const std::string& path) override;
  SolverSummary summarise() override;

 private:
  /// Runs `action`; an exception of this rank is reported to the others before it goes on its way.
  template <class Action>
  auto on_all_ranks(const Action& action);

  Communicator& communicator_;
  CommandChannel channel_;
  std::int64_t step_ = -1;
  bool advance_due_ = false;  ///< the other ranks are in, or past, the bulk update of `step_`
  std::unique_ptr<FluidSolver> solver_;
};

/// Lets the other ranks leave `follow`; on rank 0, at the end of the program. Does nothing after a failure.
void dismiss_followers(Communicator& communicator) noexcept;

}  // namespace copepod::fluid
