#include "local_components.hpp"

#include "recording/timeline.hpp"
#include "rigid_body_solver.hpp"
#include "service/rank_solver.hpp"

namespace copepod {

LocalComponents::LocalComponents() : fluid_(fluid::capabilities()), body_(body::rigid_body_capabilities()) {}

std::unique_ptr<FluidSolver> LocalComponents::make_fluid(const FluidSetup& setup, std::int64_t) {
  if (!setup.trace_directory.empty())
    recording::open_timeline(fluid_context_.timeline(), setup.trace_directory, "fluid", 0);
  return fluid::make_rank_solver(setup, alone_);
}

std::unique_ptr<BodySolver> LocalComponents::make_body(const BodySetup& setup, std::int64_t) {
  return std::make_unique<body::RigidBodySolver>(setup, &body_context_);
}

}  // namespace copepod
