#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "contract/body_setup.hpp"
#include "contract/body_solver.hpp"

namespace copepod::body {

/// A bead of the paper: radius 4 µm, mass 5.44e-13 kg.
inline BodySpecification bead(const std::string& name, const Eigen::Vector3d& position_m) {
  BodySpecification body;
  body.name = name;
  body.shape = {ShapeKind::sphere, 4e-6, 0.0};
  body.mass_kg = 5.44e-13;
  body.position_m = position_m;
  return body;
}

/// A capsule of the paper, its axis along the world's z axis: radius 4 µm, cylinder length 8 µm.
inline BodySpecification capsule(const std::string& name, const Eigen::Vector3d& position_m) {
  BodySpecification body = bead(name, position_m);
  body.shape = {ShapeKind::capsule, 4e-6, 8e-6};
  return body;
}

inline ActuatorSpecification pair_force(int body_A, int body_B) {
  ActuatorSpecification actuator;
  actuator.body_A = body_A;
  actuator.body_B = body_B;
  return actuator;
}

/// One of the other kinds.
inline ActuatorSpecification actuator_on(int body, ActuatorKind kind, const Eigen::Vector3d& direction) {
  ActuatorSpecification actuator;
  actuator.kind = kind;
  actuator.body_A = body;
  actuator.direction = direction;
  return actuator;
}

inline BodySetup setup_of(std::vector<BodySpecification> bodies, double step_s,
                          Integrator integrator = Integrator::runge_kutta_4) {
  BodySetup setup;
  setup.step_s = step_s;
  setup.integrator = integrator;
  setup.bodies = std::move(bodies);
  return setup;
}

/// Zero loads of the right shape for a solver's first step.
inline AppliedLoads no_loads(const BodySolver& solver, Eigen::Index bodies, Eigen::Index actuators = 0) {
  AppliedLoads applied;
  applied.hydrodynamic.resize(bodies);
  applied.hydrodynamic.force_N.setZero();
  applied.hydrodynamic.torque_N_m.setZero();
  applied.actuation.setZero(actuators, static_cast<Eigen::Index>(solver.driving_nodes().size()));
  return applied;
}

/// Takes `steps` steps under loads that `change` may set before each.
inline Kinematics advance(BodySolver& solver, std::int64_t steps, const std::function<void(AppliedLoads&)>& change = {},
                          Eigen::Index actuators = 0) {
  Kinematics state;
  solver.kinematics(state);
  AppliedLoads applied = no_loads(solver, state.bodies(), actuators);
  for (std::int64_t i = 0; i < steps; ++i) {
    applied.hydrodynamic.step = state.step;
    if (change) change(applied);
    solver.step(applied, state);
  }
  return state;
}

/// The reason of the error of type E that `call` throws; empty, with a test failure, if it throws none.
template <typename E>
std::string reason_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const E& error) {
    return error.what();
  }
  ADD_FAILURE() << "no error";
  return {};
}

inline testing::AssertionResult contains(const std::string& text, const std::string& part) {
  if (text.find(part) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << part << "' is not in: " << text;
}

}  // namespace copepod::body
