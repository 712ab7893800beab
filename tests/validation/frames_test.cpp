#include <numbers>

#include <gtest/gtest.h>

#include "flow_case.hpp"

namespace copepod::fluid::validation {
namespace {

struct Trial {
  const char* name = "sphere";
  MovingBoundary boundary = MovingBoundary::parabolic;
  Shape shape = {ShapeKind::sphere, 4.3, 0.0};
  Eigen::Vector3d U = {0.01, 0.007, 0.0045};
  Eigen::Vector3d W = {0.0024, 0.003, 0.0032};
  double viscosity = 0.1;
};

struct MeanLoads {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d torque = Eigen::Vector3d::Zero();
};

/// On a body that turns with the angular velocity W in a periodic cube of fluid, both of which start with the velocity
/// u: over 400 steps, in which the body crosses some cells.
template <class T>
MeanLoads mean_loads(const Trial& trial, const Eigen::Vector3d& u) {
  constexpr int settling = 400, steps = 800;
  FluidSetup setup = lattice_unit_setup({24, 24, 24}, trial.viscosity, BoundaryKind::periodic);
  setup.moving_boundary = trial.boundary;
  setup.refill = Refill::nonequilibrium;
  setup.bodies = {trial.shape};
  setup.initial_flow = {InitialFlowKind::uniform, u};
  Kinematics start = resting({Eigen::Vector3d(12.23, 12.37, 12.11)});
  start.velocity_m_per_s.col(0) = u;
  start.angular_velocity_rad_per_s.col(0) = trial.W;
  FlowCase<T> flow(setup, start);
  Kinematics& now = flow.kinematics();
  MeanLoads mean;
  Eigen::Quaterniond q(0.6, 0.48, 0.0, 0.64);
  for (int step = 0; step < steps; ++step) {
    now.orientation_wxyz.col(0) << q.w(), q.x(), q.y(), q.z();
    flow.run(1);
    now.position_m += now.velocity_m_per_s;
    q = Eigen::AngleAxisd(trial.W.norm(), trial.W.stableNormalized()) * q;
    if (step < settling) continue;
    mean.force += flow.loads().force_N.col(0) / (steps - settling);
    mean.torque += flow.loads().torque_N_m.col(0) / (steps - settling);
  }
  return mean;
}

/// What the frame of reference changes, in m |W| |U| of the force and m |U|² of the torque, m the mass displaced.
struct Difference {
  double force;
  double torque;
};

template <class T = double>
Difference difference_between_frames(const Trial& trial) {
  const MeanLoads at_rest = mean_loads<T>(trial, Eigen::Vector3d::Zero());
  const MeanLoads carried = mean_loads<T>(trial, trial.U);
  const double R = trial.shape.radius_m;
  const double m = std::numbers::pi * R * R * (4.0 / 3.0 * R + trial.shape.length_m);
  return {(carried.force - at_rest.force).norm() / (m * trial.W.norm() * trial.U.norm()),
          (carried.torque - at_rest.torque).norm() / (m * trial.U.squaredNorm())};
}

const Shape small_sphere{ShapeKind::sphere, 2.6, 0.0};
const Shape capsule{ShapeKind::capsule, 3.0, 6.0};

// With the velocity of the surface taken at the fluid cell in what the surface absorbs, the force changes by 0.2 to
// 0.4 m W × U, and a capsule that does not turn feels a torque.
TEST(Frames, DoNotChangeForceAndTorqueOnABodyThatTurns) {
  const Trial trials[] = {
      {.name = "sphere"},
      {.name = "central_linear", .boundary = MovingBoundary::central_linear},
      {.name = "interpolated", .boundary = MovingBoundary::interpolated},
      {.name = "small", .shape = small_sphere},
      {.name = "along its axis", .W = {0.004, 0.0028, 0.0018}},
      {.name = "along x about z", .U = {0.012, 0.0, 0.0}, .W = {0.0, 0.0, 0.005}},
      {.name = "capsule", .shape = capsule},
      {.name = "capsule without spin", .shape = capsule, .W = {0.0, 1e-6, 0.0}},
      {.name = "less viscous", .viscosity = 1.0 / 30.0},
  };
  for (const Trial& trial : trials) {
    const auto [force, torque] = difference_between_frames(trial);
    EXPECT_LT(force, 0.02) << trial.name;
    EXPECT_LT(torque, trial.boundary == MovingBoundary::parabolic ? 0.0125 : 0.07) << trial.name;
  }
  EXPECT_LT(difference_between_frames<float>({}).force, 0.01);
}

// The paper's bounce-back lacks m W × U.
TEST(Frames, ChangeTheForceWithBounceBack) {
  EXPECT_GT(difference_between_frames({.boundary = MovingBoundary::bounce_back}).force, 0.3);  // |W × U| is 0.4 |W| |U|
}

}  // namespace
}  // namespace copepod::fluid::validation
