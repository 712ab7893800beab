// Time of one step of the body solver for many swimmers of three beads
// (docs/decisions/body_integrator.md). Run: build/bin/body_step_benchmark

#include <cmath>
#include <string>

#include <benchmark/benchmark.h>

#include "rigid_body_solver.hpp"

namespace {

using namespace copepod;

/// Swimmers of three beads on a square lattice, bead radius 4 µm, arms of 16 µm.
BodySetup swarm(int swimmers, Integrator integrator) {
  BodySetup setup;
  setup.step_s = 7.5e-10;
  setup.integrator = integrator;
  const int row = static_cast<int>(std::ceil(std::sqrt(swimmers)));
  for (int swimmer = 0; swimmer < swimmers; ++swimmer) {
    for (int part = 0; part < 3; ++part) {
      BodySpecification bead;
      bead.name = "bead " + std::to_string(setup.bodies.size());
      bead.shape = {ShapeKind::sphere, 4e-6, 0.0};
      bead.mass_kg = 5.44e-13;
      bead.position_m = {1.2e-5 * (swimmer % row), 1.2e-5 * static_cast<int>(swimmer / row), 1.6e-5 * part};
      setup.bodies.push_back(bead);
      if (part == 0) continue;
      SpringSpecification spring;
      spring.body_A = static_cast<int>(setup.bodies.size()) - 2;
      spring.body_B = spring.body_A + 1;
      spring.stiffness_N_per_m = 2.3187;
      spring.damping_N_s_per_m = 1.57237e-7;
      spring.rest_length_m = 1.6e-5;
      setup.springs.push_back(spring);
      ActuatorSpecification stroke;
      stroke.body_A = spring.body_A;
      stroke.body_B = spring.body_B;
      setup.actuators.push_back(stroke);
    }
  }
  return setup;
}

void step_of_swimmers(benchmark::State& state, Integrator integrator) {
  const auto swimmers = static_cast<int>(state.range(0));
  const Eigen::Index bodies = 3 * swimmers;
  const BodySetup setup = swarm(swimmers, integrator);
  body::RigidBodySolver solver(setup);
  AppliedLoads applied;
  applied.hydrodynamic.resize(bodies);
  applied.hydrodynamic.force_N.setConstant(1e-9);
  applied.hydrodynamic.torque_N_m.setConstant(1e-15);
  applied.actuation.setConstant(static_cast<Eigen::Index>(setup.actuators.size()),
                                static_cast<Eigen::Index>(solver.driving_nodes().size()), 1e-9);
  Kinematics next;
  for (auto _ : state) {
    solver.step(applied, next);
    applied.hydrodynamic.step = next.step;
    benchmark::DoNotOptimize(next.position_m.data());
  }
  state.SetComplexityN(bodies);
  const auto steps = static_cast<double>(state.iterations());
  for (const auto& [phase, seconds] : solver.summarise().seconds) {
    state.counters[phase + "_ms"] = 1e3 * seconds / steps;
  }
}

/// Listing the pairs of neighbours anew, the rare part of the overlap check: construction does it once.
void start_of_swimmers(benchmark::State& state) {
  const BodySetup setup = swarm(static_cast<int>(state.range(0)), Integrator::runge_kutta_4);
  for (auto _ : state) {
    body::RigidBodySolver solver(setup);
    benchmark::DoNotOptimize(&solver);
  }
  state.SetComplexityN(3 * state.range(0));
}

BENCHMARK_CAPTURE(step_of_swimmers, runge_kutta_4, Integrator::runge_kutta_4)
    ->Arg(1)
    ->RangeMultiplier(10)
    ->Range(33, 33333)
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);
BENCHMARK_CAPTURE(step_of_swimmers, semi_implicit_euler, Integrator::semi_implicit_euler)
    ->Arg(1)
    ->RangeMultiplier(10)
    ->Range(33, 33333)
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);
BENCHMARK(start_of_swimmers)
    ->RangeMultiplier(10)
    ->Range(33, 33333)
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);

}  // namespace

BENCHMARK_MAIN();
