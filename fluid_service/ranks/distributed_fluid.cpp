#include "ranks/distributed_fluid.hpp"

#include <array>
#include <iterator>
#include <optional>
#include <span>

#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "ranks/rank_failure.hpp"
#include "recording/recorder.hpp"

namespace copepod::fluid {

namespace {

/// Order, step, and the length of the text that follows.
using Head = std::array<std::int64_t, 3>;

void broadcast(Communicator& communicator, auto& data) {
  communicator.broadcast(std::as_writable_bytes(std::span(data)));
}

}  // namespace

void send(Communicator& communicator, const Command& command) {
  if (communicator.size() == 1) return;
  std::string text = command.order == Order::construct ? conversion::to_bytes(command.setup) : command.path;
  Head head = {static_cast<std::int64_t>(command.order), command.step, std::ssize(text)};
  broadcast(communicator, head);
  if (!text.empty()) broadcast(communicator, text);
}

void receive(Communicator& communicator, Command& command) {
  Head head{};
  broadcast(communicator, head);
  command.order = static_cast<Order>(head[0]);
  command.step = head[1];
  command.path.resize(head[2]);
  if (!command.path.empty()) broadcast(communicator, command.path);
  if (command.order == Order::construct) command.setup = conversion::fluid_setup_from_bytes(command.path);
}

template <class Action>
auto DistributedFluid::on_all_ranks(const Action& action) {
  try {
    return action();
  } catch (const PeerFailed&) {
    throw;  // the other ranks have it from the one that failed
  } catch (const std::exception& error) {
    const FailureReport report = failure_of_rank(error, communicator_.rank(), step_);
    communicator_.report_failure(report);
    throw PeerFailed(report);
  }
}

template <class Action>
auto DistributedFluid::carry_out(const Command& command, const Action& action) {
  return on_all_ranks([&] {
    send(communicator_, command);
    return action();
  });
}

DistributedFluid::DistributedFluid(const FluidSetup& setup, Communicator& communicator,
                                   const RankSolverFactory& make_solver)
    : communicator_(communicator) {
  carry_out({.order = Order::construct, .setup = setup}, [&] { solver_ = make_solver(setup, communicator_); });
}

DistributedFluid::~DistributedFluid() {
  if (!advance_due_) return;
  const FailureReport report = failure_of_rank(
      ComponentLost("the run ended between exchange and bulk update (the coupler is gone). See its log.", step_),
      communicator_.rank(), step_);
  communicator_.report_failure(report);
}

void DistributedFluid::exchange(const Kinematics& kinematics, Loads& loads) {
  step_ = kinematics.step;
  carry_out({.order = Order::exchange_advance, .step = kinematics.step}, [&] {
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
  carry_out({.order = Order::save, .path = path}, [&] {
    try {
      solver_->save(path);
    } catch (const StorageError& error) {
      problem = error;
    }
  });
  if (problem) throw StorageError(*problem);
}

void DistributedFluid::restore(const std::string& path) {
  carry_out({.order = Order::restore, .path = path}, [&] { solver_->restore(path); });
}

SolverSummary DistributedFluid::summarise() {
  return carry_out({.order = Order::summarise}, [&] { return solver_->summarise(); });
}

void dismiss_followers(Communicator& communicator) noexcept {
  try {
    send(communicator, {});
  } catch (const std::exception&) {
    // A rank failed: the session aborts the others instead.
  }
}

void follow(Communicator& communicator, const RankSolverFactory& make_solver, std::atomic<std::int64_t>& current_step) {
  Timeline& timeline = communicator.context().timeline();
  // These outlive the report: their messages may be under way.
  Command command;
  Kinematics kinematics;  // of no bodies
  Loads loads;
  std::unique_ptr<FluidSolver> solver;
  const auto next_order = [&] {
    const Span waiting(timeline, "waiting");
    receive(communicator, command);
    return command.order;
  };
  const auto construct = [&] {
    const std::string& folder = command.setup.trace_directory;
    if (!folder.empty()) recording::open_timeline(timeline, folder, "fluid", communicator.rank());
    solver.reset();  // as on rank 0
    solver = make_solver(command.setup, communicator);
  };
  const auto advance_one_step = [&] {
    current_step = kinematics.step = command.step;
    timeline.set_step(current_step);
    {
      const Span exchanging(timeline, "exchanging");
      solver->exchange(kinematics, loads);
    }
    const Span advancing(timeline, "advancing");
    solver->advance();
  };
  try {
    while (next_order() != Order::stop) {
      if (command.order == Order::construct) construct();
      if (command.order == Order::exchange_advance) advance_one_step();
      if (command.order == Order::restore) solver->restore(command.path);
      if (command.order == Order::summarise) solver->summarise();
      if (command.order != Order::save) continue;
      try {
        solver->save(command.path);
      } catch (const StorageError&) {  // a full disk, of all ranks alike: rank 0 reports it, and all continue
      }
    }
  } catch (const PeerFailed&) {
    throw;
  } catch (const std::exception& error) {
    const FailureReport report = failure_of_rank(error, communicator.rank(), current_step);
    communicator.report_failure(report);
    throw Error(report.code, report.reason, report.rank, report.step);
  }
}

}  // namespace copepod::fluid
