#include "service/fluid_program.hpp"

#include "component/run_component.hpp"
#include "contract/errors.hpp"
#include "ranks/follower.hpp"
#include "service/follower_log.hpp"
#include "service/rank_solver.hpp"

namespace copepod::fluid {

namespace {

int run_leader(int argc, char** argv, Communicator& ranks, const RankSolverFactory& make_solver) {
  const FluidComponent component{capabilities(), [&](const FluidSetup& setup) {
                                   return std::make_unique<DistributedFluid>(setup, ranks, make_solver);
                                 }};
  const int code = run_fluid_component(argc, argv, component, ranks.size());
  dismiss_followers(ranks);
  return code;
}

int run_follower(int argc, char** argv, Communicator& ranks, const RankSolverFactory& make_solver) {
  const FollowerLog log(argc, argv, ranks.rank());
  try {
    follow(ranks, make_solver, log.current_step());
    log.finished();
    return static_cast<int>(ExitCode::finished);
  } catch (const Error& error) {
    log.failed(error);
    return static_cast<int>(error.code());
  }
}

}  // namespace

int run_fluid_program(int argc, char** argv, Communicator& ranks, const RankSolverFactory& make_solver) {
  return ranks.rank() == 0 ? run_leader(argc, argv, ranks, make_solver)
                           : run_follower(argc, argv, ranks, make_solver);
}

}  // namespace copepod::fluid
