#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "contract/body_setup.hpp"
#include "contract/solver.hpp"
#include "geometry/contact_time.hpp"
#include "geometry/shapes/solid.hpp"

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

/// A bead of another shape, as uniform bodies of a case have it.
inline BodySpecification shaped(const std::string& name, const Eigen::Vector3d& position_m, Shape shape) {
  BodySpecification body = bead(name, position_m);
  if (shape.kind != ShapeKind::cylinder)
    shape.radius_m = std::cbrt(make_solid(shape)->moments().volume * 0.75 / std::numbers::pi);
  body.shape = std::move(shape);
  const Eigen::Matrix3d I = inertia_tensor_kg_m2(body.shape, body.mass_kg);
  body.inertia_kg_m2 = {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)};
  return body;
}

inline Shape ellipsoid(const Eigen::Vector3d& semi_axes_m) {
  return {.kind = ShapeKind::ellipsoid, .extents_m = semi_axes_m};
}

inline Shape cylinder(double radius_m, double length_m) {
  return {.kind = ShapeKind::cylinder, .radius_m = radius_m, .length_m = length_m};
}

inline Shape box(const Eigen::Vector3d& edges_m) { return {.kind = ShapeKind::box, .extents_m = edges_m}; }

inline Shape mesh(TriangleMesh surface) {
  return {.kind = ShapeKind::mesh, .mesh = std::make_shared<const TriangleMesh>(std::move(surface))};
}

/// A box whose upper side is moved along x by a share of its height: its principal axes are not those of its frame.
inline Shape slanted_box(const Eigen::Vector3d& edges_m, double slope) {
  TriangleMesh surface = box_mesh(edges_m);
  surface.vertices_m.row(0) += slope * surface.vertices_m.row(2);
  return mesh({surface.vertices_m, surface.triangles});
}

/// Two walls, 8 µm apart along x, on a floor; not about its centre of mass.
inline Shape trough() {
  Shape shape{.kind = ShapeKind::compound};
  for (const double side : {-1.0, 1.0})
    shape.parts.push_back({.shape = box({4e-6, 30e-6, 20e-6}), .position_m = {side * 6e-6, 0, 0}});
  shape.parts.push_back({.shape = box({16e-6, 30e-6, 4e-6}), .position_m = {0, 0, -12e-6}});
  return shape;
}

/// Two spheres that touch, in the plane between x and y: its principal axes are not those of its frame.
inline Shape dumbbell() {
  Shape shape{.kind = ShapeKind::compound};
  for (const double side : {-1.0, 1.0})
    shape.parts.push_back({.shape = {ShapeKind::sphere, 3e-6}, .position_m = {1.8e-6 * side, 2.4e-6 * side, 0}});
  return shape;
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

/// A body above a floor, on which it falls and rests.
inline BodySetup falling(BodySpecification body) {
  BodySetup setup = setup_of({std::move(body)}, 1e-6);
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.contact = {stiffness_of_contact(4e-5, largest_inverse_mass_per_kg(setup.bodies)), 0.5, 0.0};
  setup.walls = {{{0, 0, 0}, {0, 0, 1}}};
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
