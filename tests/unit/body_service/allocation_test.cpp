// A program of its own because it counts every allocation of the process.

#include <cstddef>

#include <gtest/gtest.h>

#include "body_cases.hpp"
#include "rigid_body_solver.hpp"

namespace {
std::size_t allocations = 0;
}

// glibc lets a program take malloc's place; operator new and Eigen both end up here.
extern "C" void* __libc_malloc(std::size_t size);  // NOLINT(bugprone-reserved-identifier,readability-identifier-naming)
extern "C" void* malloc(std::size_t size) {
  ++allocations;
  return __libc_malloc(size);
}

namespace copepod::body {
namespace {

BodySetup chain(Integrator integrator) {
  BodySetup setup = setup_of({}, 1e-9, integrator);
  for (int i = 0; i < 300; ++i) {
    setup.bodies.push_back(i % 3 == 0 ? capsule("b", {0, 0, 2e-5 * i}) : bead("b", {0, 0, 2e-5 * i}));
    if (i % 3 == 0) continue;
    SpringSpecification spring;
    spring.body_A = i - 1;
    spring.body_B = i;
    spring.stiffness_N_per_m = 1.0;
    spring.rest_length_m = 1.9e-5;
    setup.springs.push_back(spring);
    setup.actuators.push_back(pair_force(i - 1, i));
    setup.actuators.push_back(actuator_on(i, ActuatorKind::body_torque, {0, 0, 1}));
    if (i % 3 == 2) setup.bends.push_back({i - 2, i - 1, i, 1e-12});
  }
  return setup;
}

TEST(Allocations, AreNoneInAStep) {
  for (const Integrator integrator : {Integrator::runge_kutta_4, Integrator::semi_implicit_euler}) {
    RigidBodySolver solver(chain(integrator));
    Kinematics state;
    AppliedLoads applied = no_loads(solver, 300, 400);
    applied.actuation.setConstant(1e-12);
    solver.step(applied, state);  // sizes the caller's message
    const std::size_t before = allocations;
    EXPECT_GT(before, 0U) << "nothing is counted";
    for (int step = 1; step < 100; ++step) {
      applied.hydrodynamic.step = step;
      solver.step(applied, state);
    }
    EXPECT_EQ(allocations, before);
  }
}

}  // namespace
}  // namespace copepod::body
