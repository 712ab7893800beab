// Time of one step of the body solver for many swimmers of three beads
// (docs/decisions/body_integrator.md), and of one substep of spheres that collide. Run: build/bin/body_step_benchmark

#include <cmath>
#include <string>

#include <benchmark/benchmark.h>

#include "geometry/contact_time.hpp"
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

/// Arguments: swimmers, threads.
void step_of_swimmers(benchmark::State& state, Integrator integrator) {
  const auto swimmers = static_cast<int>(state.range(0));
  const Eigen::Index bodies = 3 * swimmers;
  BodySetup setup = swarm(swimmers, integrator);
  setup.threads = static_cast<int>(state.range(1));
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
  const auto steps = static_cast<double>(state.iterations());
  for (const auto& [phase, seconds] : solver.summarise().seconds) {
    state.counters[phase + "_ms"] = 1e3 * seconds / steps;
  }
}

/// Spheres at 10 % of the volume of a periodic box, all of one speed in every direction; steps of one substep.
BodySetup suspension(int spheres) {
  constexpr double radius_m = 1e-3;
  constexpr double volume_fraction = 0.1;
  const int row = static_cast<int>(std::ceil(std::cbrt(spheres)));
  const double spacing_m = radius_m * std::cbrt(4.0 / 3.0 * 3.14159265358979 / volume_fraction);
  BodySetup setup;
  setup.step_s = 2e-5;
  setup.integrator = Integrator::semi_implicit_euler;
  setup.contact = {10.0, 0.9, 0.3};
  setup.periodic_length_m.fill(row * spacing_m);
  for (int i = 0; i < spheres; ++i) {
    BodySpecification sphere;
    sphere.name = "sphere " + std::to_string(i);
    sphere.shape = {ShapeKind::sphere, radius_m, 0.0};
    sphere.mass_kg = 1e-5;
    sphere.position_m =
        spacing_m * Eigen::Vector3d(i % row, static_cast<int>(i / row) % row, static_cast<int>(i / row / row));
    sphere.velocity_m_per_s =
        0.3 * Eigen::Vector3d(std::sin(3.0 * i), std::cos(7.0 * i), std::sin(11.0 * i)).normalized();
    setup.bodies.push_back(sphere);
  }
  return setup;
}

/// A substep of colliding spheres, pairs listed anew whenever one has moved by a quarter of its radius.
void substep_of_a_suspension(benchmark::State& state) {
  const BodySetup setup = suspension(static_cast<int>(state.range(0)));
  body::RigidBodySolver solver(setup);
  AppliedLoads applied;
  applied.hydrodynamic.resize(state.range(0));
  applied.hydrodynamic.force_N.setZero();
  applied.hydrodynamic.torque_N_m.setZero();
  applied.actuation.resize(0, 1);
  Kinematics next;
  for (auto _ : state) {
    solver.step(applied, next);
    applied.hydrodynamic.step = next.step;
    benchmark::DoNotOptimize(next.position_m.data());
  }
  state.counters["substeps"] = contact_substeps(setup);
  for (const auto& [phase, seconds] : solver.summarise().seconds)
    state.counters[phase + "_ms"] = 1e3 * seconds / static_cast<double>(state.iterations());
  state.SetComplexityN(state.range(0));
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
    ->ArgsProduct({{1, 100, 1000, 10000, 100000, 333333}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(step_of_swimmers, semi_implicit_euler, Integrator::semi_implicit_euler)
    ->ArgsProduct({{1, 100, 1000, 10000, 100000, 333333}, {1, 2}})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK(substep_of_a_suspension)
    ->Arg(1000)
    ->Arg(10000)
    ->Arg(100000)
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);
BENCHMARK(start_of_swimmers)
    ->RangeMultiplier(10)
    ->Range(33, 333333)
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);

}  // namespace

BENCHMARK_MAIN();
