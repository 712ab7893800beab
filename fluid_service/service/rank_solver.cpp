#include "service/rank_solver.hpp"

#include "contract/errors.hpp"
#include "contract/features.hpp"
#include "files/stateless_fluid.hpp"
#include "lattice_boltzmann/lattice_boltzmann.hpp"
#include "stokes/stokes_flow.hpp"

namespace copepod::fluid {

Capabilities capabilities() {
  return {
      .name = "Copepod fluid",
      .version = COPEPOD_VERSION,
      .features = features_in(
          "solver:lattice_boltzmann solver:stokes solver:vacuum collision:bgk collision:trt "
          "collision:central_moments boundary:no_slip boundary:periodic boundary:free_slip boundary:velocity "
          "boundary:pressure boundary:outflow removal boundary:signal profile:parabolic profile:table no_slip_plane "
          "symmetry_planes body_force initial_flow:uniform initial_flow:shear initial_flow:taylor_green "
          "initial_flow:taylor_green_3d initial_flow:file precision:double "
          "precision:single shape:sphere shape:capsule shape:ellipsoid shape:cylinder shape:box shape:mesh "
          "shape:compound obstacles obstacle_loads moving_boundary:bounce_back moving_boundary:interpolated "
          "moving_boundary:central_linear moving_boundary:parabolic refill:equilibrium refill:nonequilibrium "
          "refill:grad thin_films fields fields:selection flow_samples flow_samples:faces estimate mpi checkpoint "
          "snapshots")};
}

std::unique_ptr<FluidSolver> make_rank_solver(const FluidSetup& setup, Communicator& communicator) {
  switch (setup.kind) {
    case FluidKind::lattice_boltzmann:
      return make_lattice_boltzmann(setup, communicator);
    case FluidKind::vacuum:
      return std::make_unique<Vacuum>(setup, communicator);
    case FluidKind::stokes:
      return std::make_unique<StokesFlow>(setup, communicator);
  }
  throw CaseError("unknown kind of fluid solver (newer coupler?). Use lattice_boltzmann, stokes or vacuum.");
}

std::int64_t rank_bytes(const FluidSetup& setup, int ranks) {
  if (setup.kind != FluidKind::lattice_boltzmann) return 0;
  if (setup.initial_flow.kind == InitialFlowKind::file) check_flow_file(setup);
  return estimate_lattice_boltzmann_bytes(setup, ranks);
}

Estimate estimate(const FluidSetup& setup, int ranks) {
  // What a process has before the setup: libraries, MPI, sockets (docs/results/memory.md).
  constexpr std::int64_t process_bytes = std::int64_t{26} << 20;
  return {.memory_bytes = process_bytes + rank_bytes(setup, ranks), .problem = {}};
}

}  // namespace copepod::fluid
