#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"
#include "contract/solver.hpp"
#include "ranks/communicator.hpp"

namespace copepod::fluid {

/// An order from rank 0 to the other ranks.
enum class Order : std::uint32_t {
  construct,         ///< make a solver
  exchange_advance,  ///< exchange, and advance right after: the coupler never asks for one without the other
  save,
  restore,
  summarise,
  stop,  ///< leave the loop
};

/// An order and what belongs to it.
struct Command {
  Order order = Order::stop;
  FluidSetup setup = {};  ///< of construct
  std::int64_t step = 0;  ///< of exchange_advance; the solver itself distributes the kinematics
  std::string path = {};  ///< of save and restore
};

/// Broadcasts a command: of a step in one small message; a setup or path follows in another.
void send(Communicator& communicator, const Command& command);  ///< on rank 0
void receive(Communicator& communicator, Command& command);     ///< on all other ranks

/// Makes one rank's part of a solver; every method of it is called on all ranks with the same arguments, apart from the
/// kinematics: on other ranks than 0 they name the step and no bodies.
using RankSolverFactory = std::function<std::unique_ptr<FluidSolver>(const FluidSetup&, Communicator&)>;

/// A solver that is spread over ranks, as seen on rank 0: passes every call on to the other ranks
/// (`follow`) and makes the same call on its own part. Loads and summaries are those of its own part.
///
/// An exception on any rank ends all of them and is thrown here as PeerFailed, naming the rank; one of this rank is
/// reported to the others. `advance` costs no message, since the others advance by themselves.
class DistributedFluid : public FluidSolver {
 public:
  DistributedFluid(const FluidSetup& setup, Communicator& communicator, const RankSolverFactory& make_solver);
  /// Between exchange and advance the other ranks wait for this one's share of the bulk update: ends them by
  /// a failure.
  ~DistributedFluid() override;

  void exchange(const Kinematics& kinematics, Loads& loads) final;
  void advance() final;
  void save(const std::string& path) final;
  void restore(const std::string& path) final;
  SolverSummary summarise() final;

 private:
  /// Runs `action`; an exception of this rank is reported to the others.
  template <class Action>
  auto on_all_ranks(const Action& action);
  /// The same once the other ranks were sent a command.
  template <class Action>
  auto carry_out(const Command& command, const Action& action);

  Communicator& communicator_;
  std::int64_t step_ = -1;
  bool advance_due_ = false;  ///< the other ranks are in, or past, the bulk update of `step_`
  std::unique_ptr<FluidSolver> solver_;
};

/// The loop of every rank but 0: carries out the orders of rank 0 until it sends `stop`.
///
/// An exception of this rank is reported to all others; it is thrown on afterwards.
/// @param current_step  set to the step of every exchange, for logs
/// @throws PeerFailed if another rank failed, Error if this one did
void follow(Communicator& communicator, const RankSolverFactory& make_solver, std::atomic<std::int64_t>& current_step);

/// Lets the other ranks leave `follow`; on rank 0, at the end of the program. Does nothing after a failure.
void dismiss_followers(Communicator& communicator) noexcept;

}  // namespace copepod::fluid
