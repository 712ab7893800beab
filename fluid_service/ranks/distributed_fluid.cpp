#include "ranks/distributed_fluid.hpp"

#include <optional>

#include "contract/errors.hpp"
#include "ranks/rank_failure.hpp"

namespace copepod::fluid {

template <class Action>
auto DistributedFluid::on_all_ranks(const Action& action) {
  try {
    return action();
  } catch (const PeerFailed&) {
    throw;  // the other ranks have it from the one that failed
  } catch (const std::exception& error) {
    const FailureReport report = failure_of_rank(error, communicator_.rank(), step_);
    communicator_.report_failure(report);
    throw Error(report.code, report.reason, report.rank, report.step);
  }
}

DistributedFluid::DistributedFluid(const FluidSetup& setup, Communicator& communicator,
                                   const RankSolverFactory& make_solver)
    : communicator_(communicator), channel_(communicator) {
  on_all_ranks([&] {
    Command command;
    command.order = Order::construct;
    command.setup = setup;
    channel_.send(command);
    solver_ = make_solver(setup, communicator_);
  });
}

DistributedFluid::~DistributedFluid() {
  if (!advance_due_) return;
  const FailureReport report = failure_of_rank(
      ComponentLost("the run ended between exchange and bulk update (the coupler is gone). See its log.",
                    step_),
      communicator_.rank(), step_);
  communicator_.report_failure(report);
}

void DistributedFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  step_ = kinematics.step;
  on_all_ranks([&] {
    channel_.send(kinematics);
    advance_due_ = true;
    solver_->exchange(kinematics, loads);
  });
}

void DistributedFluid::advance() {
  on_all_ranks([&] { solver_->advance(); });
  advance_due_ = false;
}

/// A full disk is thrown on all ranks alike, which are in step and continue.
void DistributedFluid::save(const std::string& path) {
  std::optional<StorageError> problem;
  on_all_ranks([&] {
    Command command;
    command.order = Order::save;
    command.path = path;
    channel_.send(command);
    try {
      solver_->save(path);
    } catch (const StorageError& error) {
      problem = error;
    }
  });
  if (problem) throw StorageError(*problem);
}

void DistributedFluid::restore(const std::string& path) {
  on_all_ranks([&] {
    Command command;
    command.order = Order::restore;
    command.path = path;
    channel_.send(command);
    solver_->restore(path);
  });
}

SolverSummary DistributedFluid::summarise() {
  return on_all_ranks([&] {
    Command command;
    command.order = Order::summarise;
    channel_.send(command);
    return solver_->summarise();
  });
}

void dismiss_followers(Communicator& communicator) noexcept {
  try {
    CommandChannel(communicator).send(Command{});
  } catch (const std::exception&) {
    // A rank failed: the session aborts the others instead.
  }
}

}  // namespace copepod::fluid
