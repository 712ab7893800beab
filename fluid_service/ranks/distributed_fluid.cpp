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

void follow(Communicator& communicator, const RankSolverFactory& make_solver, std::atomic<std::int64_t>& current_step) {
  Timeline& timeline = communicator.context().timeline();
  // These outlive the report: their messages may be under way.
  CommandChannel channel(communicator);
  Command command;
  Kinematics kinematics;  // of no bodies
  Loads loads;
  std::unique_ptr<FluidSolver> solver;
  const auto receive = [&] {
    const Span waiting(timeline, "waiting");
    channel.receive(command);
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
    while (receive() != Order::stop) {
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
