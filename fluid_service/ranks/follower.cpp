#include "ranks/follower.hpp"

#include "contract/errors.hpp"
#include "ranks/command.hpp"
#include "ranks/rank_failure.hpp"
#include "recording/timeline.hpp"

namespace copepod::fluid {

namespace {

/// One rank's solver and the buffers of its calls.
class Follower {
 public:
  Follower(Communicator& communicator, const RankSolverFactory& make_solver, std::atomic<std::int64_t>& step)
      : communicator_(communicator), make_solver_(make_solver), channel_(communicator), step_(step) {}

  /// Receives one order and carries it out. @return false when there is nothing more to do
  bool obey() {
    {
      const recording::Span waiting("waiting");
      channel_.receive(command_);
    }
    switch (command_.order) {
      case Order::construct:
        open_timeline();
        solver_ = make_solver_(command_.setup, communicator_);
        return true;
      case Order::exchange_advance:
        advance_one_step();
        return true;
      case Order::save:
        save();
        return true;
      case Order::restore:
        solver_->restore(command_.path);
        return true;
      case Order::summarise:
        solver_->summarise();
        return true;
      case Order::stop:
        break;
    }
    return false;
  }

 private:
  void open_timeline() {
    const std::string& folder = command_.setup.trace_directory;
    if (!folder.empty()) recording::timeline().open(folder, "fluid", communicator_.rank());
  }

  void advance_one_step() {
    step_ = command_.kinematics.step;
    recording::timeline().set_step(step_);
    {
      const recording::Span exchanging("exchanging");
      solver_->exchange(command_.kinematics, loads_);
    }
    const recording::Span advancing("advancing");
    solver_->advance();
  }

  /// A full disk is thrown on all ranks alike: rank 0 reports it to the coupler, and all continue.
  void save() {
    try {
      solver_->save(command_.path);
    } catch (const StorageError&) {
    }
  }

  Communicator& communicator_;
  const RankSolverFactory& make_solver_;
  CommandChannel channel_;
  Command command_;
  Loads loads_;
  std::atomic<std::int64_t>& step_;
  std::unique_ptr<FluidSolver> solver_;
};

}  // namespace

void follow(Communicator& communicator, const RankSolverFactory& make_solver,
            std::atomic<std::int64_t>& current_step) {
  Follower follower(communicator, make_solver,
                    current_step);  // outlives the report: its messages may be under way
  try {
    while (follower.obey()) {
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
