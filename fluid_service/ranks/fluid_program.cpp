#include "ranks/fluid_program.hpp"

#include <iostream>
#include <memory>
#include <unistd.h>

#include <spdlog/sinks/null_sink.h>

#include "component/command_line.hpp"
#include "component/control_lane.hpp"
#include "component/run_component.hpp"
#include "contract/errors.hpp"
#include "ranks/mpi_communicator.hpp"
#include "system/process.hpp"

namespace copepod::fluid {

namespace {

/// Of --log-file and --log-level; the rest of the command line concerns rank 0.
component::Options log_options(int argc, char** argv, const Capabilities& capabilities, int rank) {
  component::Options options = *component::parse_command_line(argc, argv, session::Role::fluid, capabilities).options;
  if (options.log_file.empty()) {
    options.log_level = "warning";  // only rank 0 writes to the terminal
  } else {
    options.log_file += ".rank" + std::to_string(rank);
  }
  return options;
}

/// Log of a rank that the coupler does not talk to: `<log file of rank 0>.rank<N>`, or standard error. One that cannot
/// be opened must not leave the other ranks waiting.
std::shared_ptr<spdlog::logger> open_or_do_without(const component::Options& options, int rank,
                                                   const std::shared_ptr<component::Vitals>& vitals) {
  try {
    return component::open_log(options, session::Role::fluid, rank, vitals);
  } catch (const StorageError& error) {
    std::cerr << "warning: " << error.what() << std::endl;
    return std::make_shared<spdlog::logger>("silent", std::make_shared<spdlog::sinks::null_sink_mt>());
  }
}

int run_leader(int argc, char** argv, FluidComponent component, Communicator& ranks,
               const RankSolverFactory& make_solver) {
  component.make_solver = [&](const FluidSetup& setup, SolverContext&) {
    return std::make_unique<DistributedFluid>(setup, ranks, make_solver);
  };
  const int code = run_fluid_component(argc, argv, component, ranks.size(), ranks.context());
  dismiss_followers(ranks);
  return code;
}

int run_follower(int argc, char** argv, const FluidComponent& component, Communicator& ranks,
                 const RankSolverFactory& make_solver) {
  const auto vitals = std::make_shared<component::Vitals>(ranks.context());
  const auto log =
      open_or_do_without(log_options(argc, argv, component.capabilities, ranks.rank()), ranks.rank(), vitals);
  log->info("Rank {} of the fluid, pid {}.", ranks.rank(), getpid());
  try {
    follow(ranks, make_solver, vitals->step);
    log->info("Finished.");
    return static_cast<int>(ExitCode::finished);
  } catch (const Error& error) {
    log->error("Rank {} failed at step {}: {}", error.rank(), error.step(), error.what());
    return static_cast<int>(error.code());
  }
}

}  // namespace

int run_fluid_program(int argc, char** argv, const FluidComponent& component, const RankSolverFactory& make_solver) {
  if (!starts_service(argc, argv)) return run_fluid_component(argc, argv, component);
  if (!launched_rank()) {
    SolverContext context;
    SelfCommunicator alone(context);
    return run_leader(argc, argv, component, alone, make_solver);
  }
  MpiSession session;
  Communicator& ranks = session.ranks();
  return session.finish(ranks.rank() == 0 ? run_leader(argc, argv, component, ranks, make_solver)
                                          : run_follower(argc, argv, component, ranks, make_solver));
}

}  // namespace copepod::fluid
