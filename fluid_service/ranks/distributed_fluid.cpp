#include "ranks/distributed_fluid.hpp"

#include <algorithm>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "contract/errors.hpp"
#include "conversion/codec.hpp"
#include "ranks/rank_failure.hpp"
#include "recording/recorder.hpp"

namespace copepod::fluid {

namespace {

/// Size of the first, usually only, broadcast: all that a step needs, and most paths.
constexpr std::size_t first_part_bytes = 256;

/// What every command has; behind it the setup as bytes, or the path.
struct Head {
  Order order;
  std::int64_t step;
  std::size_t text_bytes;
};

}  // namespace

void pack(const Command& command, std::vector<std::byte>& message) {
  const std::string text = command.order == Order::construct ? conversion::to_bytes(command.setup) : command.path;
  const Head head{command.order, command.step, text.size()};
  message.resize(sizeof(head));
  std::memcpy(message.data(), &head, sizeof(head));
  const auto bytes = std::as_bytes(std::span(text));
  message.insert(message.end(), bytes.begin(), bytes.end());
}

void unpack(const std::vector<std::byte>& message, Command& command) {
  Head head{};
  if (message.size() >= sizeof(head)) std::memcpy(&head, message.data(), sizeof(head));
  if (message.size() < sizeof(head) || message.size() - sizeof(head) != head.text_bytes)
    throw std::logic_error("message between ranks is shorter than its contents");
  command.order = head.order;
  command.step = head.step;
  command.path.assign(reinterpret_cast<const char*>(message.data()) + sizeof(head), message.size() - sizeof(head));
  if (command.order == Order::construct) command.setup = conversion::fluid_setup_from_bytes(command.path);
}

void CommandChannel::send(const Command& command) {
  if (communicator_.size() == 1) return;
  pack(command, message_);
  broadcast_message();
}

void CommandChannel::receive(Command& command) {
  message_.clear();
  broadcast_message();
  unpack(message_, command);
}

void CommandChannel::broadcast_message() {
  std::uint64_t size = message_.size();
  const auto in_first_part = [&] { return std::min(message_.size(), first_part_bytes - sizeof(size)); };
  first_part_.resize(first_part_bytes);
  std::memcpy(first_part_.data(), &size, sizeof(size));
  std::copy_n(message_.begin(), in_first_part(), first_part_.begin() + sizeof(size));
  communicator_.broadcast(first_part_);
  std::memcpy(&size, first_part_.data(), sizeof(size));
  message_.resize(size);
  std::copy_n(first_part_.begin() + sizeof(size), in_first_part(), message_.begin());
  if (in_first_part() < message_.size()) communicator_.broadcast(std::span(message_).subspan(in_first_part()));
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
    channel_.send(command);
    return action();
  });
}

DistributedFluid::DistributedFluid(const FluidSetup& setup, Communicator& communicator,
                                   const RankSolverFactory& make_solver)
    : communicator_(communicator), channel_(communicator) {
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
    CommandChannel(communicator).send(Command{});
  } catch (const std::exception&) {
    // A rank failed: the session aborts the others instead.
  }
}

namespace {

/// One rank's solver and the buffers of its calls.
class Follower {
 public:
  Follower(Communicator& communicator, const RankSolverFactory& make_solver, std::atomic<std::int64_t>& step)
      : communicator_(communicator),
        timeline_(communicator.context().timeline()),
        make_solver_(make_solver),
        channel_(communicator),
        step_(step) {}

  /// Receives one order and carries it out. @return false when there is nothing more to do
  bool obey() {
    {
      const Span waiting(timeline_, "waiting");
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
    if (!folder.empty()) recording::open_timeline(timeline_, folder, "fluid", communicator_.rank());
  }

  void advance_one_step() {
    step_ = kinematics_.step = command_.step;
    timeline_.set_step(step_);
    {
      const Span exchanging(timeline_, "exchanging");
      solver_->exchange(kinematics_, loads_);
    }
    const Span advancing(timeline_, "advancing");
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
  Timeline& timeline_;
  const RankSolverFactory& make_solver_;
  CommandChannel channel_;
  Command command_;
  Kinematics kinematics_;  ///< of no bodies
  Loads loads_;
  std::atomic<std::int64_t>& step_;
  std::unique_ptr<FluidSolver> solver_;
};

}  // namespace

void follow(Communicator& communicator, const RankSolverFactory& make_solver, std::atomic<std::int64_t>& current_step) {
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
