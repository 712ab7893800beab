#include "local_components.hpp"

#include "rigid_body_solver.hpp"
#include "service/rank_solver.hpp"

namespace copepod {

LocalComponents::LocalComponents() : fluid_(fluid::capabilities()), body_(body::rigid_body_capabilities()) {}

std::unique_ptr<FluidSolver> LocalComponents::make_fluid(const FluidSetup& setup, std::int64_t) {
  return fluid::make_rank_solver(setup, alone_);
}

std::unique_ptr<BodySolver> LocalComponents::make_body(const BodySetup& setup, std::int64_t) {
  return std::make_unique<body::RigidBodySolver>(setup);
}

}  // namespace copepod
