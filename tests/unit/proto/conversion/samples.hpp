#pragma once

#include <cmath>
#include <limits>
#include <memory>

#include "contract/body_setup.hpp"
#include "contract/exchange.hpp"
#include "contract/fluid_setup.hpp"

namespace copepod::conversion {

/// A matrix of numbers that no rounding survives: thirds of very different size, signed zeros, denormals.
template <class Matrix>
Matrix awkward_numbers(Eigen::Index columns, double seed) {
  Matrix matrix(Matrix::RowsAtCompileTime, columns);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    const double n = static_cast<double>(i) + seed;
    matrix.data()[i] = i % 5 == 0 ? -0.0 : std::ldexp(n / 3.0, static_cast<int>(i % 41) - 20);
  }
  if (matrix.size() > 1) matrix.data()[1] = std::numeric_limits<double>::denorm_min();
  return matrix;
}

inline Kinematics sample_kinematics(Eigen::Index bodies) {
  Kinematics kinematics;
  kinematics.step = 123456789012;
  kinematics.position_m = awkward_numbers<Eigen::Matrix3Xd>(bodies, 1);
  kinematics.orientation_wxyz = awkward_numbers<Eigen::Matrix4Xd>(bodies, 2);
  kinematics.velocity_m_per_s = awkward_numbers<Eigen::Matrix3Xd>(bodies, 3);
  kinematics.angular_velocity_rad_per_s = awkward_numbers<Eigen::Matrix3Xd>(bodies, 4);
  return kinematics;
}

inline Loads sample_loads(Eigen::Index bodies) {
  return {7, awkward_numbers<Eigen::Matrix3Xd>(bodies, 5), awkward_numbers<Eigen::Matrix3Xd>(bodies, 6)};
}

inline AppliedLoads sample_applied_loads(Eigen::Index bodies, Eigen::Index actuators, Eigen::Index nodes) {
  const auto values = awkward_numbers<Eigen::Matrix<double, 1, Eigen::Dynamic>>(actuators * nodes, 7);
  return {sample_loads(bodies), Eigen::Map<const Eigen::MatrixXd>(values.data(), actuators, nodes)};
}

/// A tetrahedron beside a turned box.
inline Shape sample_shape() {
  TriangleMesh::Triangles corners(3, 4);
  corners << 0, 0, 0, 1,  //
      2, 1, 3, 2,         //
      1, 3, 2, 3;
  const Eigen::Matrix3Xd vertices = 1e-6 * Eigen::Matrix<double, 3, 4>{{1, -1, -1, 1}, {1, -1, 1, -1}, {1, 1, -1, -1}};
  const Shape tetrahedron{
      .kind = ShapeKind::mesh, .radius_m = 1e-6, .mesh = std::make_shared<const TriangleMesh>(vertices, corners)};
  const Shape box{.kind = ShapeKind::box, .radius_m = 1.0 / 3, .extents_m = {1e-6, 2e-6, 3e-6}};
  return {.kind = ShapeKind::compound,
          .radius_m = 2e-6,
          .parts = {{tetrahedron, {3e-6, 0, 0}}, {box, {0, 1.0 / 7, 0}, {0.5, -0.5, 0.5, -0.5}}}};
}

inline FluidSetup sample_fluid_setup() {
  FluidSetup setup;
  setup.kind = FluidKind::stokes;
  setup.step_s = 7.54831e-10;
  setup.cell_size_m = 1e-6;
  setup.density_kg_per_m3 = 1360;
  setup.kinematic_viscosity_m2_per_s = 7.36e-5;
  setup.domain_cells = {100, 101, 202};
  setup.boundaries[1].kind = BoundaryKind::periodic;
  setup.boundaries[2] = {BoundaryKind::velocity, {1e-3, -2e-3, 1.0 / 3}, 0, true};
  setup.boundaries[2].signal = {SignalKind::table, 0.7, 90, 1.5, 0.0, 11, 3, 999, {{0.0, 1.0 / 3}, {40.5, -1.0}}};
  setup.boundaries[2].profile = {0.5, -1.0 / 3};
  setup.boundaries[2].removes_bodies = true;
  setup.boundaries[3] = {BoundaryKind::pressure, {0, 0, 0}, -12.5};
  setup.boundaries[4].kind = BoundaryKind::free_slip;
  setup.no_slip_plane = 5;
  setup.symmetry_planes = {true, false, true};
  setup.body_force_N_per_m3 = {0.1, 0.2, 0.3};
  setup.initial_flow = {InitialFlowKind::shear, {1e-3, -2e-3, 1.0 / 7}, 1.0 / 9, "/flow/fields.h5", "mean"};
  setup.collision = CollisionKind::central_moments;
  setup.precision = Precision::single_precision;
  setup.film_thickness_m = 1.0 / 13;
  setup.wall_overlap_m = 1.0 / 17;
  setup.bodies = {{ShapeKind::sphere, 4e-6, 0}, {ShapeKind::capsule, 4e-6, 8e-6}};
  setup.jointed = {{0, 1}};
  setup.fields = {"/runs/a/fields",    100, 5, 50, 2, {FieldQuantity::pressure, FieldQuantity::velocity},
                  {3, 4, 0, 0, 5, 50}, 1};
  setup.flow = {7, true, {{"wake", {0.1, 0.2, 0.3}}}, {0, 5}};
  setup.parameters = R"({"b": 2})";
  return setup;
}

inline ControllerSetup sample_controller_setup() {
  return {
      "pilot", 1e-9, 100, {"Kügelchen", "ball"}, {"actuators.0"}, R"({"gain": 0.1})", "/trace", {"wake.vx_m_per_s"}};
}

inline Observation sample_observation(Eigen::Index bodies) {
  Observation observation{sample_kinematics(bodies), sample_loads(bodies)};
  observation.loads.step = observation.kinematics.step - 1;
  return observation;
}

inline BodySetup sample_body_setup() {
  BodySetup setup;
  setup.step_s = 1e-9;
  setup.integrator = Integrator::semi_implicit_euler;
  setup.gravity_m_per_s2 = {0, 0, -9.81};
  setup.fluid_density_kg_per_m3 = 998;
  setup.periodic_length_m = {1e-4, 0, 2e-4};
  BodySpecification body;
  body.name = "Kügelchen";
  body.shape = {ShapeKind::capsule, 4e-6, 8e-6};
  body.mass_kg = 5.44e-13;
  body.motion = MotionKind::axis;
  body.axis = {0, 0.6, 0.8};
  body.position_m = {1e-5, 2e-5, 1.0 / 3};
  body.orientation_wxyz = {0.5, -0.5, 0.5, -0.5};
  body.velocity_m_per_s = {1, 2, 3};
  body.angular_velocity_rad_per_s = {4, 5, 6};
  setup.bodies = {body, body};
  setup.springs = {{0, 1, 1.72965, 1.57237e-7, 1.6e-5, {1e-6, 0, 0}, {0, 1e-6, 0}}};
  setup.bends = {{1, 0, 1, 2e-16, 2.5}};
  setup.joints = {{JointKind::hinge, 0, 1, {1e-6, 0, 0}, {0, 1e-6, 0}, {0, 0.6, 0.8}, 1e-13, 2e-19, -0.5, -1.5, 0.25},
                  {JointKind::distance, 1, -1, {0, 0, 2e-6}, {3e-6, 0, 0}},
                  {JointKind::model, 0, 1}};
  setup.actuators = {{ActuatorKind::pair_force, 0, 1, {0, 0, 1}, {1e-6, 0, 0}, {0, 1e-6, 0}},
                     {ActuatorKind::world_torque, 1, -1, {0, 0.6, 0.8}},
                     {ActuatorKind::joint_motion, 1, -1, {0, 0, 1}, {0, 0, 0}, {0, 0, 0}, 1, {}},
                     {ActuatorKind::control, 0, -1, {0, 0, 1}, {0, 0, 0}, {0, 0, 0}, -1, "motor"}};
  setup.walls = {{{0, 0, 1.0 / 3}, {0, 0.6, 0.8}, {1, -2, 3}, 0.25, true}};
  setup.contact = {1.0 / 7, 0.9, 0.3};
  setup.model = {"<mujoco/>", 1e-6, 1e-15, 1.0 / 3};
  setup.parameters = R"({"a": 1})";
  return setup;
}

}  // namespace copepod::conversion
